#include "core/run/resolved_filter.h"
#include "proto/binary/clearance_csv.h"
#include "proto/json/clearance_json.h"
#include "proto/table_format.h"
#include "server/http/request_memory.h"
#include "server/routes/ray_request.h"
#include "server/routes/routes.h"
#include "server/service/answer_memory.h"
#include "server/service/hit_terms.h"

namespace sightline {
namespace {

/// A member of a group and its share of the tree around them; with kinds, its triangle and corners
/// once more.
constexpr std::uint64_t kMemberBytes = 160, kBodyBytes = 400;
/// A pair, its ends as hits, and its distance as JSON.
constexpr std::uint64_t kPairBytes =
    sizeof(ClearancePair) + 2 * (kHitBytes + sizeof(HitDetail)) + 64 + 2 * kNumberBytes;

constexpr std::string_view kCsvMediaType = table_media_type(TableFormat::kCsv);

std::uint64_t triangles_of(const Scene& scene, const ResolvedFilter& resolved) {
  std::uint64_t count = 0;
  std::size_t slot = 0;
  for (const Instance& instance : scene.description().instances) {
    for (const Primitive& primitive : scene.description().meshes[instance.mesh]->primitives)
      count += resolved.sides[slot++] != 0 ? primitive.triangle_count : 0;
  }
  return count;
}

/// What a side selects, of all that counts at all.
Result<ResolvedFilter> selection(const Scene& scene, const ClearanceSide& side,
                                 const std::string& key, RayRequest& request,
                                 const ReserveBytes& reserve) {
  const RayOptions options = request.options();
  auto chosen =
      chosen_sides(scene, side.choice, key, request.deadline(), reserve, request.warnings());
  const auto combine = [&](const ResolvedFilter& other, bool is_excluded) {
    for (std::size_t i = 0; i < chosen->sides.size(); ++i) {
      const std::uint8_t sides = other.sides[i];
      chosen->sides[i] = chosen->sides[i] & (is_excluded ? ResolvedFilter::kAll & ~sides : sides);
    }
  };
  if (chosen && options.resolved != nullptr) combine(*options.resolved, false);
  if (chosen && side.exclude) {
    const auto excluded = chosen_sides(scene, *side.exclude, key + "/exclude", request.deadline(),
                                       reserve, request.warnings());
    if (!excluded) return excluded.error();
    combine(*excluded, true);
  }
  return chosen;
}

ClearanceEnds ends_of(const Scene& scene, const ClearanceAnswer& answer, FieldSet fields,
                      TriangleId ClearancePair::*triangle, Vec3d ClearancePair::*position) {
  ClearanceEnds ends;
  ends.hits.resize(answer.pairs.size());
  ends.details.resize(answer.pairs.size());
  for (std::size_t i = 0; i < answer.pairs.size(); ++i) {
    ends.hits.instance[i] = (answer.pairs[i].*triangle).instance;
    ends.hits.triangle[i] = (answer.pairs[i].*triangle).triangle;
    ends.details[i].position = answer.pairs[i].*position;
  }
  ends.terms = hit_terms(scene, ends.hits, fields);
  return ends;
}

void ask_clearance(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  ClearanceQuery query;
  if (!request.read_json([&](std::string& body, QueryOptions& options) -> Status {
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
  const auto a = selection(scene, query.sides[0], "a", request, reserve);
  if (!a) return exchange.reply_error(a.error());
  const auto b = selection(scene, query.sides[1], "b", request, reserve);
  if (!b) return exchange.reply_error(b.error());
  const std::uint64_t members =
      triangles_of(scene, *a) + (select_alike(*a, *b) ? 0 : triangles_of(scene, *b));
  if (!request.reserve(members * (query.question.kinds ? kMemberBytes + kBodyBytes : kMemberBytes)))
    return;
  ClearanceAnswer answer;
  const Status found =
      search_lists(reserve, 1, service.limits.hits, kPairBytes, [&](std::uint64_t most) {
        query.question.total_max = most;
        return service.engine.clearance(scene, *a, *b, query.question, request.deadline(), answer,
                                        options.work);
      });
  if (!request.went_well(found)) return;
  request.add_time(&WorkReport::trace_us);
  const FieldSet fields = request.query().fields;
  const std::uint64_t pairs = answer.pairs.size();
  if (!request.reserve(2 * bytes_of_description(pairs, fields))) return;
  const ClearanceEnds of_a =
                          ends_of(scene, answer, fields, &ClearancePair::a, &ClearancePair::on_a),
                      of_b =
                          ends_of(scene, answer, fields, &ClearancePair::b, &ClearancePair::on_b);
  request.add_time(&WorkReport::describe_us);
  if (!request.reserve(bytes_of_encoded(pairs, fields, of_a.terms) +
                       bytes_of_encoded(pairs, fields, of_b.terms))) {
    return;
  }
  if (exchange.wants(kCsvMediaType)) {
    return request.reply(encode_clearance_csv(answer, query.question, fields, of_a, of_b),
                         kCsvMediaType);
  }
  request.reply(encode_clearance(answer, query.question, fields, of_a, of_b));
}

}  // namespace

void add_clearance_routes(Router& router, const Service& service) {
  router.add("POST", "/v1/scenes/{id}/clearance", with(service, ask_clearance));
}

}  // namespace sightline
