#include "core/import/gltf/gltf_animations.h"

#include <algorithm>

#include "core/import/input/json_checker.h"

namespace sightline::gltf {

using nlohmann::json;

namespace {

/// The elements of a member that is a list; none for anything else.
const json::array_t& list_of(const json& object, const char* key) {
  static const json::array_t kNone;
  const json* const list = member_of(object, key);
  return list != nullptr && list->is_array() ? list->get_ref<const json::array_t&>() : kNone;
}

/// A member that is an index below `count`; may be written as 3 or 3.0.
std::optional<std::uint32_t> index_of(const json& object, const char* key, std::size_t count) {
  const json* const value = member_of(object, key);
  if (value == nullptr || !value->is_number()) return std::nullopt;
  const auto number = value->get<double>();
  if (!(number >= 0 && number < static_cast<double>(count))) return std::nullopt;
  const auto index = static_cast<std::uint32_t>(number);
  return index == number ? std::optional(index) : std::nullopt;
}

std::string text_of(const json& object, const char* key) {
  const json* const value = member_of(object, key);
  return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
}

std::string problem_of(const char* part, std::size_t number, const std::string& what) {
  return std::string(part) + " " + std::to_string(number) + " " + what;
}

std::optional<AnimationPath> path_of(const std::string& name) {
  if (name == "translation") return AnimationPath::kTranslation;
  if (name == "rotation") return AnimationPath::kRotation;
  if (name == "scale") return AnimationPath::kScale;
  if (name == "weights") return AnimationPath::kWeights;
  return std::nullopt;
}

AnimationSamplerEntry read_sampler(const json& object, std::size_t number, std::size_t accessors,
                                   std::string& problem) {
  AnimationSamplerEntry sampler;
  const auto input = index_of(object, "input", accessors);
  const auto output = index_of(object, "output", accessors);
  if (!input || !output) problem = problem_of("sampler", number, "has no input and output");
  sampler.input = input.value_or(0);
  sampler.output = output.value_or(0);
  const json* const stated = member_of(object, "interpolation");
  const std::string name = stated != nullptr ? text_of(object, "interpolation") : "LINEAR";
  if (name == "STEP") {
    sampler.interpolation = Interpolation::kStep;
  } else if (name == "CUBICSPLINE") {
    sampler.interpolation = Interpolation::kCubicSpline;
  } else if (name != "LINEAR") {
    problem = problem_of("sampler", number, "has an unknown interpolation");
  }
  return sampler;
}

AnimationEntry read_animation(const json& object, std::size_t nodes, std::size_t accessors) {
  AnimationEntry animation;
  animation.name = text_of(object, "name");
  const auto& samplers = list_of(object, "samplers");
  for (std::size_t i = 0; i < samplers.size(); ++i) {
    animation.samplers.push_back(read_sampler(samplers[i], i, accessors, animation.problem));
  }
  const auto& channels = list_of(object, "channels");
  if (channels.empty()) animation.problem = "it has no channels";
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const json* const target = member_of(channels[i], "target");
    if (target == nullptr) {
      animation.problem = problem_of("channel", i, "has no target");
      continue;
    }
    // An extension may define what such a channel animates.
    if (member_of(*target, "node") == nullptr) continue;
    const auto sampler = index_of(channels[i], "sampler", samplers.size());
    const auto node = index_of(*target, "node", nodes);
    const auto path = path_of(text_of(*target, "path"));
    if (!sampler || !node || !path) {
      animation.problem = problem_of("channel", i,
                                     !sampler ? "has no sampler"
                                     : !node  ? "has no node"
                                              : "has an unknown path");
      continue;
    }
    animation.channels.push_back({*node, *path, *sampler});
  }
  std::stable_sort(animation.channels.begin(), animation.channels.end(),
                   [](const AnimationChannel& a, const AnimationChannel& b) {
                     return std::pair(a.node, a.path) < std::pair(b.node, b.path);
                   });
  const auto twice = std::adjacent_find(animation.channels.begin(), animation.channels.end(),
                                        [](const AnimationChannel& a, const AnimationChannel& b) {
                                          return a.node == b.node && a.path == b.path;
                                        });
  if (twice != animation.channels.end()) {
    animation.problem = problem_of("node", twice->node, "is the target of two channels");
  }
  return animation;
}

}  // namespace

void take_animations(const json& root, GltfDocument& document) {
  const std::size_t nodes = list_of(root, "nodes").size();
  const std::size_t accessors = list_of(root, "accessors").size();
  for (const json& object : list_of(root, "animations")) {
    document.animations.push_back(read_animation(object, nodes, accessors));
  }
}

}  // namespace sightline::gltf
