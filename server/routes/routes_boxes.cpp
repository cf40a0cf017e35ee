#include <algorithm>

#include "proto/binary/hit_binary.h"
#include "proto/json/box_json.h"
#include "proto/json/hit_json.h"
#include "proto/json/ray_box_json.h"
#include "proto/json/ray_json.h"
#include "server/http/body_reader.h"
#include "server/http/media_type.h"
#include "server/http/request_body.h"
#include "server/routes/column_reply.h"
#include "server/routes/routes.h"
#include "server/routes/scene_admission.h"
#include "server/service/answer_memory.h"
#include "server/service/camera_rays.h"
#include "server/service/hit_terms.h"

namespace sightline {
namespace {

void rays_boxes(Exchange& exchange, const Service& service) {
  std::string body;
  if (!read_query_body(exchange, service, body)) return;
  const auto query =
      decode_ray_boxes(body, {.max_rays = service.limits.rays, .max_boxes = service.limits.rays});
  if (!query) return exchange.reply_error(query.error());
  // An answer as columns, and as some twenty numbers and words of JSON.
  constexpr std::uint64_t kAnswerBytes = 160 + 20 * kNumberBytes;
  const std::uint64_t pairs = query->pairing == BoxPairing::kAll
                                  ? query->rays.size() * query->boxes.size()
                                  : query->rays.size();
  if (exchange.body != nullptr && !exchange.body->may_cost(pairs)) return;
  if (!went_well(exchange, exchange.reserve(pairs * kAnswerBytes))) return;

  RayBoxAnswers answers;
  const auto detail = query->planes ? RayBoxDetail::kPlanes : RayBoxDetail::kAll;
  const Deadline deadline = deadline_of(exchange, service, query->timeout_ms, query->threads);
  const Status status = service.engine.ray_boxes(query->rays, query->boxes, query->pairing, detail,
                                                 deadline, answers);
  if (!went_well(exchange, status)) return;
  exchange.reply_json(200, encode_ray_boxes(answers));
}

/// An aligned or an oriented box, which it is, and what its cursor is known by.
constexpr std::uint64_t kBoxBytes = sizeof(Box3d) + sizeof(OrientedBox) + 4 + 8;

/// The cost of the query for BodyReader::may_cost.
std::uint64_t cost_of(const Scene& scene, const BoxQuery& query) {
  const std::uint64_t boxes = query.boxes.size();
  const std::uint64_t triangles = Engine::expected_triangles(scene, query.boxes);
  // A ray of an ordinary query compares some 16 triangles. The faces of hulls cost as much as ten
  // rays for each point.
  std::uint64_t cost = 2 * boxes + triangles / 16 + 10 * query.boxes.points.size();
  // A box that contains a triangle reads which instances have a node that is not within.
  if (query.question.targets == BoxTargets::kNodes &&
      query.question.relation == BoxRelation::kContained)
    cost += boxes * (scene.description().instances.size() / 16);
  // A contact costs as much as 50 rays.
  const std::uint64_t most = boxes * std::min(query.limit, scene.instanced_triangle_count());
  if (query.question.contacts) cost += 50 * std::min(most, triangles);
  return cost;
}

bool read_boxes(Exchange& exchange, const Service& service, const Scene& scene, bool has_limit,
                BoxQuery& query) {
  std::string body;
  if (!read_body(exchange, service.limits.query_bytes, kRayJsonPadding, body)) return false;
  auto decoded = decode_boxes(
      body, {.find_camera = [&](const FileCamera& camera) { return camera_rays(scene, camera); },
             .max_boxes = service.limits.rays,
             .has_limit = has_limit,
             .limit = service.limits.hits});
  if (!decoded) {
    exchange.reply_error(decoded.error());
    return false;
  }
  query = std::move(*decoded);
  exchange.boxes = query.boxes.size();
  if (exchange.body != nullptr && !exchange.body->may_cost(cost_of(scene, query))) return false;
  const std::uint64_t parts =
      query.boxes.planes.size() * sizeof(HalfSpace) + query.boxes.points.size() * sizeof(Vec3d);
  forget_body(exchange, body, query.boxes.size() * kBoxBytes + parts);
  // A number for each box, and as JSON.
  Status status = exchange.reserve(query.boxes.size() * (8 + kNumberBytes));
  if (!status) exchange.reply_error(status.error());
  return status.ok();
}

void any_triangle(Exchange& exchange, const Service& service) {
  const auto scene = admit_scene_query(exchange, service);
  BoxQuery query;
  if (!scene || !read_boxes(exchange, service, *scene, false, query)) return;

  Column<std::uint8_t> touched;
  if (!went_well(exchange, service.engine.boxes_any(
                               *scene, query.boxes,
                               deadline_of(exchange, service, query.timeout_ms, query.threads),
                               touched, query.question.relation)))
    return;
  if (!reply_columns(exchange, [&] { return encode_occlusion_binary(touched, nullptr); }))
    exchange.reply_json(200, encode_occlusion(touched));
}

void count_triangles(Exchange& exchange, const Service& service) {
  const auto scene = admit_scene_query(exchange, service);
  BoxQuery query;
  if (!scene || !read_boxes(exchange, service, *scene, false, query)) return;

  Column<std::uint64_t> totals;
  if (!went_well(exchange,
                 service.engine.boxes_count(
                     *scene, query.boxes, query.question,
                     deadline_of(exchange, service, query.timeout_ms, query.threads), totals)))
    return;
  if (!reply_columns(exchange, [&] { return encode_counts_binary(totals, nullptr); }))
    exchange.reply_json(200, encode_counts(totals));
}

/// The listed triangles or nodes in the file's terms.
HitTerms terms_of(const Scene& scene, const BoxLists& lists, BoxTargets targets) {
  if (targets == BoxTargets::kTriangles) {
    HitBatch hits;
    hits.resize(lists.triangles.size());
    for (std::size_t i = 0; i < lists.triangles.size(); ++i) {
      hits.instance[i] = lists.triangles[i].instance;
      hits.triangle[i] = lists.triangles[i].triangle;
    }
    return hit_terms(scene, hits,
                     {HitField::kPrimitive, HitField::kTriangle, HitField::kNode, HitField::kMesh});
  }
  HitTerms terms;
  for (const std::uint32_t node : lists.nodes) {
    terms.node.push_back(scene.description().nodes[node].file_node);
    terms.node_name.push_back(scene.description().nodes[node].name);
  }
  return terms;
}

/// Where each list begins. Errors: CURSOR_STALE, CURSOR_OF_OTHERS.
Status begin_lists(std::uint64_t revision, BoxQuery& query) {
  const bool of_nodes = query.question.targets == BoxTargets::kNodes;
  for (std::size_t i = 0; i < query.cursors.size(); ++i) {
    const ListCursor& cursor = query.cursors[i];
    const std::string place = "/boxes/" + std::to_string(i) + "/cursor";
    if (cursor.from != 0 && cursor.revision != revision) {
      return Error{ErrorKind::kConflict, "CURSOR_STALE",
                   "the list was begun in revision " + std::to_string(cursor.revision) +
                       ", the scene is now revision " + std::to_string(revision) + ": begin anew",
                   place};
    }
    if (cursor.from != 0 && cursor.of_nodes != of_nodes) {
      return Error{ErrorKind::kInvalid, "CURSOR_OF_OTHERS",
                   std::string("this is the cursor of a list of ") +
                       (cursor.of_nodes ? "nodes" : "triangles"),
                   place};
    }
    if (cursor.from != 0 && cursor.question != query.questions[i]) {
      return Error{ErrorKind::kInvalid, "CURSOR_OF_OTHERS",
                   "this is the cursor of a list of another shape, or of another mode", place};
    }
    query.question.from.push_back(cursor.from);
  }
  return success();
}

void list(Exchange& exchange, const Service& service) {
  if (!admit_query_type(exchange) || !admit_body(exchange, service.limits.query_bytes)) return;
  const SceneSnapshot stored = admit_scene(exchange, service);
  BoxQuery query;
  if (!stored || !read_boxes(exchange, service, *stored->scene, true, query)) return;
  const auto& scene = stored->scene;
  if (!went_well(exchange, begin_lists(stored->revision, query))) return;

  BoxLists lists;
  Column<std::uint64_t> totals;
  const Deadline deadline = deadline_of(exchange, service, query.timeout_ms, query.threads);
  // An entry in the lists of the threads and in all of them joined, its terms, and as JSON.
  constexpr std::uint64_t kEntryBytes = 3 * kHitBytes + 64 + 5 * kNumberBytes;
  constexpr std::uint64_t kContactBytes = sizeof(double) + sizeof(Vec3d) + 4 * kNumberBytes;
  const Status found = search_lists(
      reserve_from(exchange.memory), query.boxes.size(), service.limits.hits,
      kEntryBytes + (query.question.contacts ? kContactBytes : 0), [&](std::uint64_t most) {
        return service.engine.boxes_list(*scene, query.boxes, query.question, {query.limit, most},
                                         deadline, lists, totals);
      });
  if (!found) return exchange.reply_error(found.error());
  BoxContacts contacts;
  if (query.question.contacts &&
      !went_well(exchange,
                 service.engine.boxes_contacts(*scene, query.boxes, lists, deadline, contacts)))
    return;
  const BoxTargets targets = query.question.targets;
  const HitTerms terms = terms_of(*scene, lists, targets);
  if (!went_well(exchange, exchange.reserve(bytes_of_names(terms.node_name) +
                                            bytes_of_names(terms.mesh_name))))
    return;
  exchange.reply_json(
      200, encode_box_lists(lists, totals, targets, terms, stored->revision, query.questions,
                            query.question.contacts ? &contacts : nullptr));
}

}  // namespace

void add_box_routes(Router& router, const Service& service) {
  router.add("POST", "/v1/rays-boxes", with(service, rays_boxes));
  router.add("POST", "/v1/scenes/{id}/boxes:any", with(service, any_triangle));
  router.add("POST", "/v1/scenes/{id}/boxes:list", with(service, list));
  router.add("POST", "/v1/scenes/{id}/boxes:count", with(service, count_triangles));
}

}  // namespace sightline
