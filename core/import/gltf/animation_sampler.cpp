#include "core/import/gltf/animation_sampler.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/import/input/refusal.h"
#include "core/scene/node_transform.h"

namespace sightline::gltf {

namespace {

/// Weights that one animation may set: as many as a record of a scene can hold.
constexpr std::size_t kMostWeights = 1u << 22;

Error unusable(const std::string& what) { return invalid("ANIMATION_INVALID", what, "/animation"); }

Error unusable_in(const GltfDocument& document, std::size_t number, const std::string& what) {
  const std::string& name = document.animations[number].name;
  return unusable("animation " + std::to_string(number) +
                  (name.empty() ? "" : " (\"" + shortened(name) + "\")") + ": " + what);
}

bool has_numbers(const AccessorView& view) {
  if (view.component == Component::kF32) return true;
  return view.normalized && view.component != Component::kU32;
}

/// Writes the numbers of value `slot`: one element, or `width` elements of one number.
void load_value(const AccessorView& view, std::uint64_t slot, std::vector<double>& out) {
  if (view.components > 1) {
    load_element(view, slot, view.components, out.data());
    return;
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    load_element(view, slot * out.size() + i, 1, &out[i]);
  }
}

/// Sets `first` to the value between two rotations.
void turn_between(double u, const std::vector<double>& second, std::vector<double>& first) {
  const double c =
      ((first[0] * second[0] + first[1] * second[1]) + first[2] * second[2]) + first[3] * second[3];
  const double s = c < 0 ? -1.0 : 1.0;
  const double a = std::acos(std::min(std::fabs(c), 1.0)), sine = std::sin(a);
  double from = 1 - u, to = s * u;
  if (sine != 0) {
    from = std::sin(a * (1 - u)) / sine;
    to = s * (std::sin(a * u) / sine);
  }
  for (std::size_t i = 0; i < 4; ++i) first[i] = from * first[i] + to * second[i];
}

}  // namespace

std::vector<std::uint32_t> morph_targets(const GltfDocument& document) {
  std::vector<std::uint32_t> targets;
  targets.reserve(document.model.meshes.size());
  for (const tinygltf::Mesh& mesh : document.model.meshes) {
    std::size_t most = 0;
    for (const tinygltf::Primitive& part : mesh.primitives)
      most = std::max(most, part.targets.size());
    targets.push_back(static_cast<std::uint32_t>(most));
  }
  return targets;
}

Result<AccessorView> AnimationSampler::view(std::uint32_t accessor, bool reads) {
  if (const auto known = views_.find({accessor, reads}); known != views_.end())
    return known->second;
  const tinygltf::Accessor& stated = document_.model.accessors[accessor];
  ViewStore& views = accessors_.views();
  const auto is_at_hand = [&](int view) {
    return views.is_at_hand(static_cast<std::size_t>(view));
  };
  const bool has_view = GltfDocument::has_view(stated);
  const bool is_sparse = stated.sparse.isSparse;
  if ((has_view && !is_at_hand(stated.bufferView)) ||
      (is_sparse && !(is_at_hand(stated.sparse.indices.bufferView) &&
                      is_at_hand(stated.sparse.values.bufferView)))) {
    return unusable("accessor " + std::to_string(accessor) +
                    " lies in a buffer that no geometry needs");
  }
  const bool is_compressed =
      has_view && views.is_meshopt(static_cast<std::size_t>(stated.bufferView));
  if (is_compressed && is_sparse) {
    return unusable("accessor " + std::to_string(accessor) +
                    ": compressed elements cannot be sparse");
  }
  auto found =
      is_compressed && !reads ? accessors_.view_to_decode(accessor) : accessors_.view(accessor);
  if (found) views_.emplace(std::pair(accessor, reads), *found);
  return found;
}

std::size_t AnimationSampler::width_of(const AnimationChannel& channel) const {
  switch (channel.path) {
    case AnimationPath::kTranslation:
    case AnimationPath::kScale:
      return 3;
    case AnimationPath::kRotation:
      return 4;
    case AnimationPath::kWeights:
      break;
  }
  const int mesh = document_.model.nodes[channel.node].mesh;
  return mesh < 0 ? 0 : targets_[static_cast<std::size_t>(mesh)];
}

Result<AnimationSampler::Views> AnimationSampler::views(const AnimationEntry& animation,
                                                        const AnimationChannel& channel,
                                                        std::size_t width, bool reads) {
  const AnimationSamplerEntry& sampler = animation.samplers[channel.sampler];
  const tinygltf::Node& node = document_.model.nodes[channel.node];
  const bool is_weights = channel.path == AnimationPath::kWeights;
  const std::string place = "node " + std::to_string(channel.node);
  if (width == 0) return unusable(place + " has no morph targets");
  if (!is_weights && !node.matrix.empty()) {
    return unusable(place + " has a matrix and cannot be animated");
  }
  auto input = view(sampler.input, reads);
  if (!input) return std::move(input).error();
  auto output = view(sampler.output, reads);
  if (!output) return std::move(output).error();
  if (input->components != 1 || input->component != Component::kF32) {
    return unusable("accessor " + std::to_string(sampler.input) +
                    " must be SCALAR of float32: it has the times of keys");
  }
  const bool needs_float =
      channel.path == AnimationPath::kTranslation || channel.path == AnimationPath::kScale;
  if (output->components != (is_weights ? 1 : width) || !has_numbers(*output) ||
      (needs_float && output->component != Component::kF32)) {
    return unusable("accessor " + std::to_string(sampler.output) +
                    " is of another type than the values of its channel");
  }
  const std::uint64_t each = (sampler.interpolation == Interpolation::kCubicSpline ? 3 : 1) *
                             (is_weights ? std::uint64_t{width} : 1);
  if (output->count != input->count * each) {
    return unusable("accessor " + std::to_string(sampler.output) + " has " +
                    std::to_string(output->count) + " elements, " + std::to_string(input->count) +
                    " keys need " + std::to_string(input->count * each));
  }
  return Views{*input, *output};
}

Status AnimationSampler::check(std::size_t number) {
  const AnimationEntry& animation = document_.animations[number];
  if (!animation.problem.empty()) return unusable_in(document_, number, animation.problem);
  for (const AnimationChannel& channel : animation.channels) {
    auto found = views(animation, channel, width_of(channel), false);
    if (!found) return unusable_in(document_, number, found.error().message);
  }
  return success();
}

Result<double> AnimationSampler::duration(std::size_t number) {
  if (Status status = check(number); !status) return std::move(status).error();
  double last = 0;
  for (const AnimationChannel& channel : document_.animations[number].channels) {
    const auto input = view(document_.animations[number].samplers[channel.sampler].input, true);
    if (!input) return unusable_in(document_, number, input.error().message);
    double seconds = 0;
    load_element(*input, input->count - 1, 1, &seconds);
    if (!std::isfinite(seconds)) {
      return unusable_in(document_, number, "its times do not rise, or are not finite");
    }
    last = std::max(last, seconds);
  }
  return last;
}

Result<AnimationSampler::Keys> AnimationSampler::keys_at(const AccessorView& input,
                                                         double seconds) {
  if (const auto known = keys_.find(input.accessor); known != keys_.end()) return known->second;
  Keys keys;
  double before = 0;
  for (std::uint64_t i = 0; i < input.count; ++i) {
    double time = 0;
    load_element(input, i, 1, &time);
    if (!std::isfinite(time) || (i > 0 && !(time > before))) {
      return unusable("accessor " + std::to_string(input.accessor) + ": the time of key " +
                      std::to_string(i) +
                      " is not finite, or not after the time of the key before it");
    }
    if (time <= seconds) {
      keys = {i, i, 0, 0};
    } else if (i > 0 && before < seconds) {
      keys = {i - 1, i, (seconds - before) / (time - before), time - before};
    }
    before = time;
  }
  keys_.emplace(input.accessor, keys);
  return keys;
}

Result<std::vector<double>> AnimationSampler::value(const AnimationEntry& animation,
                                                    const AnimationChannel& channel,
                                                    double seconds) {
  const std::size_t width = width_of(channel);
  const Interpolation kind = animation.samplers[channel.sampler].interpolation;
  auto found = views(animation, channel, width, true);
  if (!found) return std::move(found).error();
  auto keys = keys_at(found->input, seconds);
  if (!keys) return std::move(keys).error();
  const bool is_cubic = kind == Interpolation::kCubicSpline;
  const bool is_turn = channel.path == AnimationPath::kRotation;
  const auto load = [&](std::uint64_t key, std::uint64_t part, std::vector<double>& out) {
    load_value(found->output, is_cubic ? 3 * key + part : key, out);
  };
  std::vector<double> v(width), next(width);
  load(keys->first, 1, v);
  if (keys->first != keys->second && kind != Interpolation::kStep) {
    load(keys->second, 1, next);
    const double u = keys->u;
    if (is_cubic) {
      std::vector<double> out(width), in(width);
      load(keys->first, 2, out);
      load(keys->second, 0, in);
      const double uu = u * u, uuu = uu * u;
      const double p = (2 * uuu - 3 * uu) + 1, q = 3 * uu - 2 * uuu;
      const double b = keys->seconds * ((uuu - 2 * uu) + u), a = keys->seconds * (uuu - uu);
      for (std::size_t i = 0; i < width; ++i) {
        v[i] = ((p * v[i] + b * out[i]) + q * next[i]) + a * in[i];
      }
    } else if (is_turn) {
      turn_between(u, next, v);
    } else {
      for (std::size_t i = 0; i < width; ++i) v[i] = (1 - u) * v[i] + u * next[i];
    }
  }
  if (is_cubic && is_turn) {
    const double length = std::sqrt(Quaternion{v[0], v[1], v[2], v[3]}.norm());
    for (double& x : v) x = x / length;
  }
  return v;
}

Result<std::vector<NodeChange>> AnimationSampler::sample(std::size_t number, double seconds) {
  if (Status status = check(number); !status) return std::move(status).error();
  keys_.clear();
  const AnimationEntry& animation = document_.animations[number];
  std::vector<NodeChange> changes;
  std::size_t weights = 0;
  for (std::size_t i = 0; i < animation.channels.size();) {
    NodeChange change;
    change.node = animation.channels[i].node;
    const tinygltf::Node& node = document_.model.nodes[change.node];
    NodeTransform transform{{}, node.translation, node.rotation, node.scale};
    bool moves = false;
    for (; i < animation.channels.size() && animation.channels[i].node == change.node; ++i) {
      const AnimationChannel& channel = animation.channels[i];
      if (channel.path == AnimationPath::kWeights) weights += width_of(channel);
      if (weights > kMostWeights) {
        return unusable_in(document_, number, "it sets more than 4194304 weights");
      }
      auto found = value(animation, channel, seconds);
      if (!found) return unusable_in(document_, number, found.error().message);
      moves = moves || channel.path != AnimationPath::kWeights;
      std::vector<double>& target = channel.path == AnimationPath::kTranslation
                                        ? transform.translation
                                    : channel.path == AnimationPath::kRotation ? transform.rotation
                                    : channel.path == AnimationPath::kScale    ? transform.scale
                                                                               : change.weights;
      target = *std::move(found);
    }
    if (std::any_of(change.weights.begin(), change.weights.end(),
                    [](double weight) { return !std::isfinite(weight); })) {
      return unusable_in(document_, number,
                         "node " + std::to_string(change.node) + ": a weight is not finite");
    }
    if (moves) {
      auto matrix = matrix_of(transform);
      if (!matrix) {
        return unusable_in(document_, number,
                           "node " + std::to_string(change.node) + ": " + matrix.error().message);
      }
      change.parent_from_node = *matrix;
    }
    changes.push_back(std::move(change));
  }
  return changes;
}

}  // namespace sightline::gltf
