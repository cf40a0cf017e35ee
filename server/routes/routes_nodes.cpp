#include <charconv>
#include <string_view>

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

/// `place`: pointer of the change in the body.
Result<NodeChange> change_of(const NodePatch& patch, const std::string& place) {
  NodeChange change;
  change.node = patch.node;
  change.hidden = patch.hidden;
  change.mask = patch.mask;
  change.weights = patch.weights;
  change.removed = patch.removed;
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
               "a node is called by its index in the file's \"nodes\"", ""};
}

/// What a changed scene takes beside the previous one, and the way there: a guess from above, from
/// 2.4 kB for a node with a mesh.
std::uint64_t bytes_to_change(const SceneDescription& scene, const SceneChange& change) {
  constexpr std::uint64_t kNode = 512, kInstance = 2048;
  const EditedSize size = size_after(scene, change.nodes);
  return size.nodes * kNode + size.instances * kInstance +
         (scene.poser && may_pose(scene, change) ? scene.poser->bytes_of_call() : 0);
}

void apply(Exchange& exchange, Service& service, const SceneChange& change) {
  std::uint64_t bytes = change.nodes.size() * 2 * sizeof(NodeChange);
  if (const SceneSnapshot scene = service.store.find(exchange.scene_id); scene && scene->scene) {
    bytes += bytes_to_change(scene->scene->description(), change);
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
    return exchange.reply_error(error);
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

void patch_node(Exchange& exchange, Service& service) {
  constexpr std::uint64_t kMostBytes = 64 << 10;
  std::string body;
  if (!admit_json_change(exchange, kMostBytes) || !read_body(exchange, kMostBytes, 0, body)) return;
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
  constexpr std::uint64_t kMostBytes = 8 << 20;
  // As a document of JSON, and as decoded.
  constexpr std::uint64_t kBytesForByte = 24;
  std::string body;
  if (!admit_json_change(exchange, kMostBytes) || !read_body(exchange, kMostBytes, 0, body)) return;
  if (!went_well(exchange, exchange.reserve(body.size() * kBytesForByte))) return;
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
