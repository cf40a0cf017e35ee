#include <charconv>

#include "core/scene/node_transform.h"
#include "proto/json/node_json.h"
#include "server/http/media_type.h"
#include "server/http/request_body.h"
#include "server/routes/preconditions.h"
#include "server/routes/routes.h"
#include "server/routes/scene_admission.h"

namespace sightline {
namespace {

Result<NodeChange> change_of(const std::string& node, const NodePatch& patch) {
  NodeChange change;
  const auto [end, error] = std::from_chars(node.data(), node.data() + node.size(), change.node);
  if (error != std::errc() || end != node.data() + node.size()) {
    return Error{ErrorKind::kNotFound, "NODE_NOT_FOUND",
                 "a node is called by its index in the file's \"nodes\"", ""};
  }
  change.hidden = patch.hidden;
  change.mask = patch.mask;
  if (patch.moves()) {
    auto matrix = matrix_of({patch.matrix, patch.translation, patch.rotation, patch.scale});
    if (!matrix) return std::move(matrix).error();
    change.parent_from_node = *matrix;
  }
  return change;
}

/// What a changed scene takes beside the one before it, and the way there: a guess from above, from
/// 2.4 kB for a node with a mesh.
std::uint64_t bytes_to_change(const SceneDescription& scene) {
  constexpr std::uint64_t kNode = 512, kInstance = 2048;
  return scene.nodes.size() * kNode + scene.instances.size() * kInstance;
}

void patch_node(Exchange& exchange, Service& service) {
  constexpr std::uint64_t kMostBytes = 64 << 10;
  std::string body;
  if (!admit_json_change(exchange, kMostBytes) || !read_body(exchange, kMostBytes, 0, body)) return;
  const auto patch = decode_node_patch(body);
  if (!patch) return exchange.reply_error(patch.error());
  const auto change = change_of(exchange.node_id, *patch);
  if (!change) return exchange.reply_error(change.error());
  std::uint64_t bytes = 0;
  if (const SceneSnapshot scene = service.store.find(exchange.scene_id); scene && scene->scene) {
    bytes = bytes_to_change(scene->scene->description());
  }
  // Without the scene in hand: who waits here would keep a revision that nobody asks any more.
  if (!went_well(exchange, exchange.reserve(bytes))) return;
  const auto changed = service.store.change(exchange.scene_id, *change, precondition_of(exchange));
  if (!changed) return exchange.reply_error(changed.error());
  reply_done(exchange, 200, **changed);
  exchange.response.set_header("X-Scene-Revision", std::to_string((*changed)->revision));
}

}  // namespace

void add_node_routes(Router& router, Service& service) {
  router.add("PATCH", "/v1/scenes/{id}/nodes/{node}", with(service, patch_node));
}

}  // namespace sightline
