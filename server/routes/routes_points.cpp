#include "proto/binary/hit_binary.h"
#include "proto/binary/point_binary.h"
#include "server/routes/ray_request.h"
#include "server/routes/routes.h"
#include "server/service/answer_memory.h"
#include "server/service/hit_terms.h"

namespace sightline {
namespace {

InsideColumns columns_of(const PointQuery& query, const InsideAnswers& answers) {
  return {query.method,    answers.inside,      answers.on_surface, answers.reliable,
          answers.winding, answers.generalized, answers.error,      answers.open_edges};
}

/// A binary answer has no place for a text.
void add_unreliable_header(Exchange& exchange, const InsideAnswers& answers) {
  if (answers.open_edges == 0) return;
  exchange.response.set_header("X-Sightline-Unreliable", encode_unreliable(answers.open_edges));
}

void ask_inside(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  PointQuery query;
  if (!request.read_points({.has_method = true}, query)) return;
  InsideAnswers answers;
  // A ray for each point, and three columns of answers as numbers and words.
  if (!request.reserve(query.points.size() * (kRayBytes + 6 * kNumberBytes)) ||
      !request.went_well(service.engine.inside(request.scene(), query.points, query.method,
                                               request.deadline(), answers, request.options()))) {
    return;
  }
  request.add_time(&WorkReport::trace_us);
  const InsideColumns columns = columns_of(query, answers);
  if (!request.is_binary()) return request.reply(encode_inside(columns));
  add_unreliable_header(exchange, answers);
  request.reply(encode_inside_binary(columns));
}

void ask_distance(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  PointQuery query;
  if (!request.read_points({.has_method = true, .has_max_distance = true}, query)) return;
  InsideAnswers answers;
  if (!request.reserve(query.points.size() * (kRayBytes + kHitBytes + 7 * kNumberBytes)) ||
      !request.went_well(service.engine.signed_distances(
          request.scene(), query.points, query.method, query.max_distance, request.deadline(),
          answers, request.options()))) {
    return;
  }
  request.add_time(&WorkReport::trace_us);
  const InsideColumns columns = columns_of(query, answers);
  if (!request.is_binary())
    return request.reply(encode_signed_distances(columns, answers.distance));
  add_unreliable_header(exchange, answers);
  request.reply(encode_signed_distances_binary(columns, answers.distance));
}

/// The hits of all points one behind the other, without the slots that are misses.
HitLists lists_of(const HitBatch& slots, std::size_t points, std::size_t count) {
  HitLists lists;
  lists.first.assign(1, 0);
  for (std::size_t i = 0; i < points; ++i) {
    std::size_t found = 0;
    while (found < count && slots.hit(i * count + found)) ++found;
    const auto copy = [&](auto& to, const auto& from) {
      const auto begin = from.begin() + static_cast<std::ptrdiff_t>(i * count);
      to.insert(to.end(), begin, begin + static_cast<std::ptrdiff_t>(found));
    };
    copy(lists.hits.t, slots.t);
    copy(lists.hits.instance, slots.instance);
    copy(lists.hits.triangle, slots.triangle);
    lists.first.push_back(lists.hits.size());
  }
  return lists;
}

/// What is asked of them. `of` is the point of each hit.
bool describe(RayRequest& request, const Service& service, const HitBatch& hits,
              const Column<Vec3d>& of, HitDescription& about) {
  const FieldSet fields = request.query().fields;
  if (!request.reserve(
          bytes_of_description(hits.size(), fields, request.query().named_fields.size())))
    return false;
  if (fields.has_any_of(kDetailFields) &&
      !request.went_well(service.engine.nearest_details(request.scene(), of, hits,
                                                        request.deadline(), about.details))) {
    return false;
  }
  about.terms = hit_terms(request.scene(), hits, fields);
  const RayBatch no_rays;
  const DescribedHits described{.scene = request.scene(),
                                .rays = no_rays,
                                .hits = hits,
                                .fields = fields,
                                .named = request.query().named_fields};
  if (!request.went_well(read_attributes(service.engine, described, request.deadline(), about))) {
    return false;
  }
  if (fields.has(HitField::kDistance)) about.terms.distance = hits.t;
  request.add_time(&WorkReport::describe_us);
  return request.reserve(bytes_of_encoded(hits.size(), fields, about.terms));
}

void ask_closest(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  PointQuery query;
  if (!request.read_points({.has_max_distance = true, .has_fields = true}, query)) return;
  HitBatch hits;
  if (!request.reserve(query.points.size() * kHitBytes) ||
      !request.went_well(service.engine.nearest(request.scene(), query.points, query.max_distance,
                                                1, request.deadline(), hits, request.options()))) {
    return;
  }
  request.add_time(&WorkReport::trace_us);
  HitDescription about;
  if (!describe(request, service, hits, query.points, about)) return;
  request.reply_hits(hits, about);
}

void ask_nearest(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  PointQuery query;
  if (!request.read_points({.has_max_distance = true, .has_count = true, .has_fields = true},
                           query)) {
    return;
  }
  const std::size_t count = query.count;
  if (query.points.size() > service.limits.hits / count) {
    return exchange.reply_error(
        {ErrorKind::kTooLarge, "TOO_MANY_HITS",
         "points times count may be " + std::to_string(service.limits.hits) + " together",
         "/count"});
  }
  HitBatch slots;
  // Slots, lists of those that are none, and the point of each.
  const std::uint64_t slot_bytes = 2 * kHitBytes + sizeof(Vec3d);
  if (!request.reserve(query.points.size() * count * slot_bytes) ||
      !request.went_well(service.engine.nearest(request.scene(), query.points, query.max_distance,
                                                count, request.deadline(), slots,
                                                request.options()))) {
    return;
  }
  request.add_time(&WorkReport::trace_us);
  const HitLists lists = lists_of(slots, query.points.size(), count);
  Column<Vec3d> of;
  of.reserve(lists.hits.size());
  for (std::size_t i = 0; i < query.points.size(); ++i) {
    of.insert(of.end(), lists.first[i + 1] - lists.first[i], query.points[i]);
  }
  HitDescription about;
  if (!describe(request, service, lists.hits, of, about)) return;
  const FieldSet fields = request.query().fields;
  request.reply(request.is_binary()
                    ? encode_nearest_lists_binary(lists, about.details, about.terms, fields)
                    : encode_nearest_lists(lists, about.details, about.terms, fields));
}

void ask_sky(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  PointQuery query;
  if (!request.read_points({.has_max_distance = true,
                            .has_count = true,
                            .has_directions = true,
                            .default_count = 256,
                            .max_count = 65536},
                           query)) {
    return;
  }
  const auto rays = std::min<std::uint64_t>(
      query.items(), std::max<std::uint64_t>(query.count, Engine::kRaysAtOnce));
  const Hemisphere samples{{query.points.begin(), query.points.end()},
                           {query.normals.begin(), query.normals.end()},
                           query.count,
                           query.seed,
                           query.uniform};
  Column<std::uint64_t> unblocked;
  if (!request.reserve(query.points.size() * (2 * kRayBytes + 3 * kNumberBytes) +
                       rays * (kRayBytes + 1)) ||
      !request.went_well(service.engine.sky(request.scene(), samples,
                                            {query.min_distance, query.max_distance},
                                            request.deadline(), unblocked, request.options()))) {
    return;
  }
  request.add_time(&WorkReport::trace_us);
  request.reply(request.is_binary() ? encode_counts_binary(unblocked, nullptr)
                                    : encode_sky(query.count, unblocked));
}

}  // namespace

void add_point_routes(Router& router, const Service& service) {
  router.add("POST", "/v1/scenes/{id}/points:inside", with(service, ask_inside));
  router.add("POST", "/v1/scenes/{id}/points:closest", with(service, ask_closest));
  router.add("POST", "/v1/scenes/{id}/points:nearest", with(service, ask_nearest));
  router.add("POST", "/v1/scenes/{id}/points:distance", with(service, ask_distance));
  router.add("POST", "/v1/scenes/{id}/points:sky", with(service, ask_sky));
}

}  // namespace sightline
