#include <algorithm>
#include <charconv>
#include <string_view>
#include <unordered_set>

#include "core/scene/edited_nodes.h"
#include "core/scene/node_transform.h"
#include "core/scene/poser.h"
#include "proto/json/node_json.h"
#include "server/http/media_type.h"
#include "server/http/request_body.h"
#include "server/routes/preconditions.h"
#include "server/routes/routes.h"
#include "server/routes/scene_admission.h"

namespace sightline {
namespace {

constexpr std::uint64_t kMostChangeBytes = 8 << 20;

/// `numbers`: three for each.
SharedColumn<Vec3f> positions_of(const std::vector<float>& numbers) {
  UnsetColumn<Vec3f> positions(numbers.size() / 3);
  for (std::size_t i = 0; i < positions.size(); ++i)
    positions[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
  return SharedColumn<Vec3f>::shared(std::move(positions));
}

/// `place`: pointer of the change in the body.
Result<NodeChange> change_of(const NodePatch& patch, const std::string& place) {
  NodeChange change;
  change.node = patch.node;
  change.hidden = patch.hidden;
  change.mask = patch.mask;
  change.weights = patch.weights;
  change.removed = patch.removed;
  if (!patch.positions.empty()) change.positions = positions_of(patch.positions);
  if (patch.copy_of) change.added = AddedNode{*patch.copy_of, patch.parent, patch.name};
  if (patch.moves()) {
    auto matrix = matrix_of({patch.matrix, patch.translation, patch.rotation, patch.scale});
    if (!matrix) {
      Error error = std::move(matrix).error();
      error.pointer = place + error.pointer;
      return error;
    }
    change.parent_from_node = *matrix;
  }
  return change;
}

/// The number of the path's node. Errors: NODE_NOT_FOUND.
Result<std::uint32_t> node_of(const std::string& text) {
  std::uint32_t node = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), node);
  if (error == std::errc() && end == text.data() + text.size()) return node;
  return Error{ErrorKind::kNotFound, "NODE_NOT_FOUND",
               "the path names a node by its number, 0 to 4294967295", ""};
}

/// Bytes of the record's text, twice, and its hash for the positions of changes.
std::uint64_t bytes_of_positions(std::span<const NodeChange> changes) {
  constexpr std::uint64_t kPosition = 96;
  std::uint64_t bytes = 0;
  for (const NodeChange& change : changes) bytes += change.positions.size() * kPosition;
  return bytes;
}

std::uint64_t bytes_of_copy(const Mesh& mesh) {
  return mesh.positions.size() * (2 * sizeof(Vec3f) + 1) + mesh.indices.listed().size_bytes();
}

/// Bytes of the meshes that the changes make.
std::uint64_t bytes_of_edited_meshes(const SceneDescription& scene,
                                     std::span<const NodeChange> changes) {
  std::unordered_set<std::uint32_t> edited;
  for (const NodeChange& change : changes) {
    if (!change.positions.empty()) edited.insert(change.node);
  }
  if (edited.empty()) return 0;
  // An added node has the mesh of another one.
  std::uint64_t bytes = 0, largest = 0;
  for (const auto& mesh : scene.meshes) largest = std::max(largest, bytes_of_copy(*mesh));
  for (const NodeChange& change : changes) {
    if (change.added && edited.erase(change.node) > 0) bytes += largest;
  }
  for (const Instance& instance : scene.instances) {
    if (edited.erase(scene.nodes[instance.node].file_node) > 0)
      bytes += bytes_of_copy(*scene.meshes[instance.mesh]);
  }
  return bytes;
}

/// What a changed scene takes beside the previous one, and the way there: a guess from above, from
/// 2.4 kB for a node with a mesh.
std::uint64_t bytes_to_change(const StoredScene& stored, const SceneChange& change) {
  const SceneDescription& scene = stored.scene->description();
  constexpr std::uint64_t kNode = 512, kInstance = 2048;
  const EditedSize size = size_after(scene, change.nodes);
  return size.nodes * kNode + size.instances * kInstance + bytes_of_positions(stored.changes) +
         bytes_of_positions(change.nodes) + bytes_of_edited_meshes(scene, change.nodes) +
         (scene.poser && may_pose(scene, change) ? scene.poser->bytes_of_call() : 0);
}

void apply(Exchange& exchange, Service& service, const SceneChange& change) {
  std::uint64_t bytes = change.nodes.size() * 2 * sizeof(NodeChange);
  if (const SceneSnapshot scene = service.store.find(exchange.scene_id); scene && scene->scene) {
    bytes += bytes_to_change(*scene, change);
  }
  // Without the scene in hand: a request that waits here would hold a revision that nobody asks any
  // more.
  if (!went_well(exchange, exchange.reserve(bytes))) return;
  const auto changed = service.store.change(exchange.scene_id, change, precondition_of(exchange));
  if (!changed) {
    Error error = changed.error();
    // The node of a path is in no body.
    constexpr std::string_view kNode = "/nodes/0";
    if (!exchange.node_id.empty() && error.pointer.starts_with(kNode)) {
      error.pointer.erase(0, kNode.size());
    }
    return reply_store_error(exchange, service, error);
  }
  reply_done(exchange, 200, **changed);
  exchange.response.set_header("X-Scene-Revision", std::to_string((*changed)->revision));
}

void delete_node(Exchange& exchange, Service& service) {
  const auto node = node_of(exchange.node_id);
  if (!node) return exchange.reply_error(node.error());
  NodeChange change;
  change.node = *node;
  change.removed = true;
  apply(exchange, service, {{}, {change}});
}

/// Reads the body, and reserves memory to decode it. On failure it has answered.
bool read_change(Exchange& exchange, std::string& body) {
  // As a document of JSON, and as decoded.
  constexpr std::uint64_t kBytesForByte = 24;
  return admit_json_change(exchange, kMostChangeBytes) &&
         read_body(exchange, kMostChangeBytes, 0, body) &&
         went_well(exchange, exchange.reserve(body.size() * kBytesForByte));
}

void patch_node(Exchange& exchange, Service& service) {
  std::string body;
  if (!read_change(exchange, body)) return;
  auto patch = decode_node_patch(body);
  if (!patch) return exchange.reply_error(patch.error());
  const auto node = node_of(exchange.node_id);
  if (!node) return exchange.reply_error(node.error());
  patch->node = *node;
  const auto change = change_of(*patch, "");
  if (!change) return exchange.reply_error(change.error());
  apply(exchange, service, {{}, {*change}});
}

void patch_nodes(Exchange& exchange, Service& service) {
  std::string body;
  if (!read_change(exchange, body)) return;
  const auto patches = decode_node_patches(body);
  if (!patches) return exchange.reply_error(patches.error());
  SceneChange change;
  if (const auto& animation = patches->animation) {
    change.animation = AnimationTime{animation->name, animation->index, animation->time};
  }
  change.nodes.reserve(patches->nodes.size());
  for (const NodePatch& patch : patches->nodes) {
    auto node = change_of(patch, "/nodes/" + std::to_string(change.nodes.size()));
    if (!node) return exchange.reply_error(node.error());
    change.nodes.push_back(*std::move(node));
  }
  apply(exchange, service, change);
}

}  // namespace

void add_node_routes(Router& router, Service& service) {
  router.add("PATCH", "/v1/scenes/{id}/nodes", with(service, patch_nodes));
  router.add("PATCH", "/v1/scenes/{id}/nodes/{node}", with(service, patch_node));
  router.add("DELETE", "/v1/scenes/{id}/nodes/{node}", with(service, delete_node));
}

}  // namespace sightline
