#include "core/run/resolved_filter.h"
#include "proto/json/clearance_json.h"
#include "server/http/request_memory.h"
#include "server/routes/ray_request.h"
#include "server/routes/routes.h"
#include "server/service/answer_memory.h"
#include "server/service/hit_terms.h"

namespace sightline {
namespace {

/// A member of a group and its share of the tree around them.
constexpr std::uint64_t kMemberBytes = 160;
/// A pair, its terms, and as JSON.
constexpr std::uint64_t kPairBytes = sizeof(ClearancePair) + 128 + 14 * kNumberBytes;

std::uint64_t triangles_of(const Scene& scene, const ResolvedFilter& resolved) {
  std::uint64_t count = 0;
  std::size_t slot = 0;
  for (const Instance& instance : scene.description().instances) {
    for (const Primitive& primitive : scene.description().meshes[instance.mesh]->primitives)
      count += resolved.sides[slot++] != 0 ? primitive.triangle_count : 0;
  }
  return count;
}

/// What is chosen, of all that counts at all.
Result<ResolvedFilter> selection(const Scene& scene, const TriangleChoice& choice,
                                 const std::string& key, const ResolvedFilter* resolved,
                                 const Deadline& deadline, const ReserveBytes& reserve,
                                 SelectionWarnings* warnings) {
  auto chosen = chosen_sides(scene, choice, key, deadline, reserve, warnings);
  for (std::size_t i = 0; chosen && resolved != nullptr && i < resolved->sides.size(); ++i)
    chosen->sides[i] = chosen->sides[i] & resolved->sides[i];
  return chosen;
}

/// Those of one side in the file's terms.
HitTerms terms_of_side(const Scene& scene, const ClearanceAnswer& answer,
                       TriangleId ClearancePair::*side) {
  HitBatch hits;
  hits.resize(answer.pairs.size());
  for (std::size_t i = 0; i < answer.pairs.size(); ++i) {
    hits.instance[i] = (answer.pairs[i].*side).instance;
    hits.triangle[i] = (answer.pairs[i].*side).triangle;
  }
  return hit_terms(scene, hits,
                   {HitField::kPrimitive, HitField::kTriangle, HitField::kNode, HitField::kMesh});
}

void ask_clearance(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  ClearanceQuery query;
  if (!request.read_json([&](std::string& body, RayQuery& options) -> Status {
        auto decoded = decode_clearance(body, service.limits.hits);
        if (!decoded) return decoded.error();
        query = std::move(*decoded);
        options = query.options;
        return success();
      })) {
    return;
  }
  const Scene& scene = request.scene();
  const RayOptions options = request.options();
  const ReserveBytes reserve = reserve_from(exchange.memory);
  const auto a = selection(scene, query.a, "a", options.resolved, request.deadline(), reserve,
                           request.warnings());
  if (!a) return exchange.reply_error(a.error());
  const auto b = selection(scene, query.b, "b", options.resolved, request.deadline(), reserve,
                           request.warnings());
  if (!b) return exchange.reply_error(b.error());
  const std::uint64_t members =
      triangles_of(scene, *a) + (select_alike(*a, *b) ? 0 : triangles_of(scene, *b));
  if (!request.reserve(members * kMemberBytes)) return;
  ClearanceAnswer answer;
  const Status found =
      search_lists(reserve, 1, service.limits.hits, kPairBytes, [&](std::uint64_t most) {
        query.question.total_max = most;
        return service.engine.clearance(scene, *a, *b, query.question, request.deadline(), answer,
                                        options.work);
      });
  if (!request.went_well(found)) return;
  request.add_time(&WorkReport::trace_us);
  const HitTerms of_a = terms_of_side(scene, answer, &ClearancePair::a),
                 of_b = terms_of_side(scene, answer, &ClearancePair::b);
  request.add_time(&WorkReport::describe_us);
  std::uint64_t names = 0;
  for (const HitTerms* terms : {&of_a, &of_b})
    names += bytes_of_names(terms->node_name) + bytes_of_names(terms->mesh_name);
  if (!request.reserve(names)) return;
  request.reply(encode_clearance(answer, query.question.pairs, of_a, of_b));
}

}  // namespace

void add_clearance_routes(Router& router, const Service& service) {
  router.add("POST", "/v1/scenes/{id}/clearance", with(service, ask_clearance));
}

}  // namespace sightline
