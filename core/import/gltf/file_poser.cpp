#include "core/import/gltf/file_poser.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "core/base/watch.h"
#include "core/import/gltf/animation_sampler.h"
#include "core/import/gltf/mesh_reader.h"
#include "core/import/gltf/posed_parts.h"
#include "core/import/input/refusal.h"
#include "core/query/similar_names.h"
#include "core/scene/edited_meshes.h"

namespace sightline::gltf {

namespace {

constexpr std::uint32_t kNoMesh = 0xffffffffu;

using DocumentPointer = std::shared_ptr<const GltfDocument>;

/// Bytes of a document, without the texts in it.
std::uint64_t bytes_of(const GltfDocument& document) {
  const tinygltf::Model& model = document.model;
  std::uint64_t bytes = model.nodes.size() * sizeof(tinygltf::Node) +
                        model.accessors.size() * sizeof(tinygltf::Accessor) +
                        model.bufferViews.size() * sizeof(tinygltf::BufferView) +
                        model.meshes.size() * sizeof(tinygltf::Mesh);
  for (const auto& [primitive, entries] : document.attributes)
    bytes += sizeof(std::vector<AttributeEntry>) + entries.size() * sizeof(AttributeEntry);
  for (const tinygltf::Mesh& mesh : model.meshes)
    bytes += mesh.primitives.size() * sizeof(tinygltf::Primitive);
  for (const AnimationEntry& animation : document.animations) {
    bytes += sizeof(AnimationEntry) + animation.channels.size() * sizeof(AnimationChannel) +
             animation.samplers.size() * sizeof(AnimationSamplerEntry);
  }
  return bytes;
}

/// A file that was opened again.
struct Opened {
  Opened(const Retained& retained, const ImportLimits& limits, DocumentPointer read)
      : owner(std::move(read)),
        document(*owner),
        buffers(document.buffers, retained.binary, std::nullopt, limits),
        budget(limits),
        views(document, buffers, budget),
        accessors(document, views, limits) {
    for (const auto& [buffer, bytes] : retained.buffers) buffers.provide(buffer, bytes->bytes());
    // As after the import: only what is open is read. They were decoded before.
    for (const std::size_t buffer : retained.data_uris) static_cast<void>(buffers.bytes(buffer));
  }
  DocumentPointer owner;
  const GltfDocument& document;
  BufferStore buffers;
  Budget budget;
  ViewStore views;
  AccessorReader accessors;
};

/// By mesh of the file, weights without trailing zeros, and skin: nodes with equal keys show one
/// mesh (MeshReader::mesh_of).
using PoseKey = std::tuple<int, std::vector<double>, int>;
PoseKey key_of(const tinygltf::Model& model, const tinygltf::Node& node) {
  const tinygltf::Mesh& mesh = model.meshes[static_cast<std::size_t>(node.mesh)];
  PoseKey key{node.mesh, !node.weights.empty() ? node.weights : mesh.weights, node.skin};
  std::vector<double>& weights = std::get<1>(key);
  while (!weights.empty() && weights.back() == 0) weights.pop_back();
  return key;
}

/// Gives nodes the meshes of their new pose.
class Reposing {
 public:
  Reposing(SceneDescription& scene, const PoseChange& change, const GltfDocument& document)
      : scene_(scene), change_(change), document_(document) {}

  /// Finds the nodes with an instance that a mesh of another pose will have.
  void find() {
    const std::vector<bool> skins = moved_skins();
    for (std::uint32_t i = 0; i < scene_.nodes.size(); ++i) {
      // Nothing poses what a client added.
      if (scene_.nodes[i].added || scene_.nodes[i].removed) continue;
      const tinygltf::Node node = posed_node(i);
      const bool is_posable = node.skin >= 0 || scene_.nodes[i].morph_targets > 0;
      if (node.mesh < 0 || !is_posable || of_node(i).empty()) continue;
      const auto [known, is_new] =
          number_.try_emplace(key_of(document_.model, node), groups_.size());
      if (is_new) groups_.push_back({.node = node});
      Group& group = groups_[known->second];
      const bool is_touched =
          change_.weighted[i] || (node.skin >= 0 && skins[static_cast<std::size_t>(node.skin)]);
      if (!is_touched) group.mesh = of_node(i).front().mesh;
      group.nodes.push_back({i, is_touched});
    }
  }

  /// Reads the meshes that no node has yet.
  Status read(MeshReader& meshes, const std::vector<std::shared_ptr<const Mesh>>& made) {
    for (Group& group : groups_) {
      if (group.mesh != kNoMesh) continue;
      auto mesh = meshes.mesh_of(group.node);
      if (!mesh) return std::move(mesh).error();
      if (mesh->has_value()) group.made = **mesh;
    }
    if (Status status = meshes.finish(); !status) return status;
    for (Group& group : groups_) {
      if (group.made != kNoMesh) group.fresh = made[group.made];
    }
    return success();
  }

  /// Gives each mesh that was read a place in the scene.
  PosedMeshes place() {
    PosedMeshes posed;
    std::vector<bool> is_taken(scene_.meshes.size(), true);
    for (const std::uint32_t mesh : free_meshes()) is_taken[mesh] = false;
    for (Group& group : groups_) {
      if (group.fresh != nullptr) posed.fresh.push_back(place(group, is_taken));
      for (const auto& [node, is_touched] : group.nodes) {
        if (!is_touched) continue;
        for (Instance& instance : of_node(node)) {
          instance.mesh = group.mesh;
          posed.instances.push_back(
              static_cast<std::uint32_t>(&instance - scene_.instances.data()));
        }
      }
    }
    std::sort(posed.fresh.begin(), posed.fresh.end());
    scene_.counts.posed_meshes = posed.fresh.size();
    posed.renumbered = remove_unused_meshes(scene_);
    count_flat_triangles(scene_);
    return posed;
  }

 private:
  struct Group {
    tinygltf::Node node;  ///< with the mesh, weights and skin of all
    /// and whether the change poses each
    std::vector<std::pair<std::uint32_t, bool>> nodes = {};
    std::uint32_t mesh = kNoMesh;  ///< in the scene
    std::uint32_t made = kNoMesh;  ///< index of the mesh that was read
    std::shared_ptr<const Mesh> fresh = {};
  };

  std::span<Instance> of_node(std::uint32_t node) {
    return instances_of(std::span(scene_.instances), node);
  }

  /// What of a node poses its mesh.
  tinygltf::Node posed_node(std::uint32_t i) const {
    const tinygltf::Node& source = document_.model.nodes[scene_.nodes[i].file_node];
    tinygltf::Node node;
    node.mesh = source.mesh;
    node.skin = source.skin;
    node.weights = scene_.nodes[i].weights ? *scene_.nodes[i].weights : source.weights;
    return node;
  }

  std::vector<bool> moved_skins() const {
    std::unordered_map<std::uint32_t, std::uint32_t> number;
    for (std::uint32_t i = 0; i < scene_.nodes.size(); ++i) number[scene_.nodes[i].file_node] = i;
    std::vector<bool> moved(document_.skins.size());
    for (std::size_t k = 0; k < moved.size(); ++k) {
      const auto& joints = document_.skins[k].joints;
      moved[k] = std::any_of(joints.begin(), joints.end(), [&](std::uint32_t joint) {
        const auto found = number.find(joint);
        return found != number.end() && change_.moved[found->second];
      });
    }
    return moved;
  }

  /// Old meshes that only instances have which get another one.
  std::vector<std::uint32_t> free_meshes() {
    std::vector<bool> is_kept(scene_.meshes.size(), true);
    for (const Group& group : groups_) {
      for (const auto& [node, is_touched] : group.nodes) {
        if (is_touched) is_kept[of_node(node).front().mesh] = false;
      }
    }
    for (const Group& group : groups_) {
      for (const auto& [node, is_touched] : group.nodes) {
        if (!is_touched) is_kept[of_node(node).front().mesh] = true;
      }
    }
    std::vector<std::uint32_t> free;
    for (std::uint32_t i = 0; i < is_kept.size(); ++i) {
      if (!is_kept[i]) free.push_back(i);
    }
    return free;
  }

  std::uint32_t place(Group& group, std::vector<bool>& is_taken) {
    for (const auto& [node, is_touched] : group.nodes) {
      const std::uint32_t old = of_node(node).front().mesh;
      if (!is_taken[old] && old < group.mesh) group.mesh = old;
    }
    if (group.mesh == kNoMesh) {
      group.mesh = static_cast<std::uint32_t>(scene_.meshes.size());
      scene_.meshes.emplace_back();
      is_taken.push_back(true);
    }
    is_taken[group.mesh] = true;
    scene_.meshes[group.mesh] = group.fresh;
    return group.mesh;
  }

  SceneDescription& scene_;
  const PoseChange& change_;
  const GltfDocument& document_;
  std::map<PoseKey, std::size_t> number_;
  std::vector<Group> groups_;  ///< in the order of the walk
};

class FilePoser : public Poser {
 public:
  FilePoser(Retained retained, const ImportOptions& options, std::uint64_t bytes_of_call)
      : retained_(std::move(retained)), bytes_of_call_(bytes_of_call) {
    options_.limits = options.limits;
    options_.scene = options.scene;
  }

  Result<PosedMeshes> pose(SceneDescription& scene, const PoseChange& change) const override {
    auto opened = open();
    if (!opened) return std::move(opened).error();
    Opened& file = **opened;
    Reposing reposing(scene, change, file.document);
    reposing.find();
    // The reader adds its meshes to a description, and takes the joints from its nodes.
    SceneDescription made;
    made.nodes.swap(scene.nodes);
    Warnings warnings;  // those of the file are known
    MeshReader meshes(file.document, file.accessors, retained_.file, true, file.budget, made,
                      warnings);
    Status status = reposing.read(meshes, made.meshes);
    made.nodes.swap(scene.nodes);
    if (!status) {
      Error error = std::move(status).error();
      if (error.code == "GLTF_TRANSFORM_INVALID") error.code = "TRANSFORM_INVALID";
      error.pointer.clear();  // it points into the file
      return error;
    }
    return reposing.place();
  }

  Result<std::vector<NodeChange>> sample(const AnimationTime& time) const override {
    auto opened = open();
    if (!opened) return std::move(opened).error();
    Opened& file = **opened;
    const auto number = find(file.document.animations, time);
    if (!number) return number.error();
    auto changes = AnimationSampler(file.document, file.accessors).sample(*number, time.seconds);
    if (!changes) return changes;
    std::erase_if(*changes, [&](const NodeChange& change) {
      return !std::binary_search(loaded_.begin(), loaded_.end(), change.node);
    });
    return changes;
  }

  Result<std::vector<AnimationSummary>> animations() const override {
    auto opened = open();
    if (!opened) return std::move(opened).error();
    Opened& file = **opened;
    AnimationSampler sampler(file.document, file.accessors);
    std::vector<AnimationSummary> summaries;
    for (std::size_t i = 0; i < file.document.animations.size(); ++i) {
      const AnimationEntry& entry = file.document.animations[i];
      AnimationSummary summary;
      summary.name = entry.name;
      for (const AnimationChannel& channel : entry.channels) {
        if (summary.nodes.empty() || summary.nodes.back() != channel.node)
          summary.nodes.push_back(channel.node);
      }
      const auto duration = sampler.duration(i);
      if (duration) {
        summary.duration = *duration;
      } else {
        summary.problem = duration.error().message;
      }
      summaries.push_back(std::move(summary));
    }
    return summaries;
  }

  std::uint64_t bytes() const override {
    const std::lock_guard hold(mutex_);
    return retained_.copied + (document_ ? bytes_of(*document_) : 0);
  }
  std::uint64_t bytes_of_call() const override { return bytes_of_call_; }
  /// Nodes that animations target and the loaded scene has, ascending.
  void set_loaded(std::vector<std::uint32_t> nodes) { loaded_ = std::move(nodes); }

 private:
  Result<std::unique_ptr<Opened>> open() const {
    DocumentPointer document;
    {
      const std::lock_guard hold(mutex_);
      document = document_;
    }
    if (document == nullptr) {
      const std::string_view text(reinterpret_cast<const char*>(retained_.json.data()),
                                  retained_.json.size());
      auto read = read_document(text, options_);
      if (!read) return std::move(read).error();
      document = std::make_shared<const GltfDocument>(*std::move(read));
      const std::lock_guard hold(mutex_);
      if (retained_.json.size() <= kCachedJson) document_ = document;
    }
    return std::make_unique<Opened>(retained_, options_.limits, std::move(document));
  }

  static Result<std::size_t> find(const std::vector<AnimationEntry>& animations,
                                  const AnimationTime& time) {
    const auto unknown = [&](std::string what, const char* member) {
      return invalid("ANIMATION_UNKNOWN", std::move(what), std::string("/animation/") + member);
    };
    if (!time.name) {
      if (time.index < animations.size()) return std::size_t{time.index};
      return unknown(
          "the scene has " + std::to_string(animations.size()) + " animations, counted from 0",
          "index");
    }
    for (std::size_t i = 0; i < animations.size(); ++i) {
      if (animations[i].name == *time.name) return i;
    }
    constexpr std::uint64_t kMostSteps = 1 << 20;
    const Deadline never;
    DeadlineWatch watch(never);
    const std::string similar = similar_names_text(
        *time.name, animations.size(),
        [&](std::size_t i) { return std::string_view(animations[i].name); }, kMostSteps, watch);
    return unknown("there is no animation \"" + shortened(*time.name) + "\"" + similar, "name");
  }

  /// Documents of texts up to this size are cached.
  static constexpr std::size_t kCachedJson = 8 << 20;

  Retained retained_;
  ImportOptions options_;
  std::uint64_t bytes_of_call_;
  mutable std::mutex mutex_;          ///< protects document_
  mutable DocumentPointer document_;  ///< null: it is read when it is needed
  std::vector<std::uint32_t> loaded_;
};

/// A bound of what a call allocates, from the text of the file and the meshes that it may pose.
std::uint64_t bytes_of_call(const ImportedFile& file, const SceneDescription& scene) {
  constexpr std::uint64_t kPerByte = 16, kPerVertex = 64, kPerNode = 512;
  std::uint64_t bytes = file.chunks.json.size() * kPerByte + scene.nodes.size() * kPerNode;
  std::vector<bool> seen(scene.meshes.size());
  for (const Instance& instance : scene.instances) {
    const Node& node = scene.nodes[instance.node];
    if (!instance.posed && node.morph_targets == 0) continue;
    if (seen[instance.mesh]) continue;
    seen[instance.mesh] = true;
    const Mesh& mesh = *scene.meshes[instance.mesh];
    bytes += mesh.positions.size() * kPerVertex + mesh.indices.size() * sizeof(std::uint32_t);
  }
  return bytes;
}

/// At most so many as there are targets.
std::shared_ptr<const std::vector<double>> weights_of(std::vector<double> stated,
                                                      std::uint32_t targets) {
  if (stated.size() > targets) stated.resize(targets);
  return std::make_shared<const std::vector<double>>(std::move(stated));
}

}  // namespace

void attach_poser(const ImportedFile& file, Budget& budget, SceneDescription& scene,
                  Warnings& warnings) {
  const std::vector<std::uint32_t> targets = morph_targets(file.document);
  PosedParts parts(file, targets);
  std::vector<std::uint32_t> loaded;
  std::map<int, std::shared_ptr<const std::vector<double>>> defaults;  // by mesh
  for (Node& node : scene.nodes) {
    const tinygltf::Node& source = file.document.model.nodes[node.file_node];
    loaded.push_back(node.file_node);
    parts.add_node(source);
    if (source.mesh < 0) continue;
    const auto mesh = static_cast<std::size_t>(source.mesh);
    node.morph_targets = targets[mesh];
    if (node.morph_targets == 0) continue;
    if (!source.weights.empty()) {
      node.weights = weights_of(source.weights, node.morph_targets);
      continue;
    }
    auto& shared = defaults[source.mesh];
    if (shared == nullptr)
      shared = weights_of(file.document.model.meshes[mesh].weights, node.morph_targets);
    node.weights = shared;
  }
  AnimationSampler sampler(file.document, file.accessors);
  for (std::size_t i = 0; i < file.document.animations.size(); ++i) {
    parts.add_animation(file.document.animations[i]);
    if (Status status = sampler.check(i); !status)
      warnings.add(status.error().message + "; it cannot be sampled");
  }
  if (!parts.has_any() || (file.shared.owner == nullptr && !file.options.copies_attributes)) return;
  auto retained = parts.retain(budget);
  if (!retained) {
    warnings.add("what other poses need was left out: " + retained.error().message);
    return;
  }
  auto poser =
      std::make_shared<FilePoser>(*std::move(retained), file.options, bytes_of_call(file, scene));
  if (!file.document.animations.empty()) {
    std::sort(loaded.begin(), loaded.end());
    poser->set_loaded(std::move(loaded));
  }
  scene.poser = std::move(poser);
}

}  // namespace sightline::gltf
