#include <optional>

#include "core/run/kept_sides.h"
#include "proto/hit_json.h"
#include "proto/ray_json.h"
#include "server/hit_terms.h"
#include "server/request_body.h"
#include "server/routes.h"
#include "server/scene_admission.h"

namespace sightline {
namespace {

/// What a query's filter means for the scene; null when it keeps all. Returns false after it has
/// answered.
bool read_filter(Exchange& exchange, const Scene& scene, const HitFilter& filter,
                 std::optional<KeptSides>& kept) {
  if (filter.keeps_all()) return true;
  auto sides = kept_sides(scene, filter);
  if (!sides) {
    exchange.reply_error(sides.error());
    return false;
  }
  kept = std::move(*sides);
  return true;
}

const KeptSides* pointer(const std::optional<KeptSides>& kept) { return kept ? &*kept : nullptr; }

/// The limits are the service's, the keys are the caller's.
bool read_rays(Exchange& exchange, const Service& service, RayJsonRules rules, RayQuery& query) {
  std::string body;
  if (!read_body(exchange, service.limits.query_bytes, kRayJsonPadding, body)) return false;
  rules.max_rays = service.limits.rays;
  rules.max_hits = service.limits.hits;
  auto decoded = decode_rays(body, rules);
  if (!decoded) {
    exchange.reply_error(decoded.error());
    return false;
  }
  query = std::move(*decoded);
  exchange.rays = query.rays.size();
  return true;
}

void closest(Exchange& exchange, const Service& service) {
  const auto scene = admit_scene_query(exchange, service);
  RayQuery query;
  std::optional<KeptSides> kept;
  if (!scene || !read_rays(exchange, service, {}, query) ||
      !read_filter(exchange, *scene, query.filter, kept)) {
    return;
  }

  const Deadline deadline = service.deadline();
  HitBatch hits;
  if (Status status = service.engine.closest(*scene, query.rays, deadline, hits, pointer(kept));
      !status) {
    return exchange.reply_error(status.error());
  }
  HitDescription description;
  if (Status status = describe_hits(service.engine, *scene, query.rays, hits, query.fields,
                                    query.normalize, deadline, description);
      !status) {
    return exchange.reply_error(status.error());
  }
  exchange.reply_json(
      200, encode_hits(hits, description.details, description.terms, query.fields, query.layout));
}

void any(Exchange& exchange, const Service& service) {
  const auto scene = admit_scene_query(exchange, service);
  RayQuery query;
  std::optional<KeptSides> kept;
  if (!scene || !read_rays(exchange, service, {.has_fields = false}, query) ||
      !read_filter(exchange, *scene, query.filter, kept)) {
    return;
  }

  Column<std::uint8_t> occluded;
  if (Status status =
          service.engine.any(*scene, query.rays, service.deadline(), occluded, pointer(kept));
      !status) {
    return exchange.reply_error(status.error());
  }
  exchange.reply_json(200, encode_occlusion(occluded));
}

void all(Exchange& exchange, const Service& service) {
  const auto scene = admit_scene_query(exchange, service);
  RayQuery query;
  std::optional<KeptSides> kept;
  if (!scene ||
      !read_rays(exchange, service, {.has_crossings = true, .has_max_hits = true}, query) ||
      !read_filter(exchange, *scene, query.filter, kept)) {
    return;
  }
  const Deadline deadline = service.deadline();
  HitLists lists;
  Column<std::uint64_t> totals;
  Status status = service.engine.all(*scene, query.rays, query.crossings, query.max_hits,
                                     service.limits.hits, deadline, lists, totals, pointer(kept));
  HitDescription description;
  if (status) {
    const bool needs_rays = query.normalize || query.fields.has(HitField::kDistance) ||
                            query.fields.has_any_of(kDetailFields);
    status = describe_hits(service.engine, *scene,
                           needs_rays ? rays_of_hits(query.rays, lists) : RayBatch(), lists.hits,
                           query.fields, query.normalize, deadline, description);
  }
  if (!status) return exchange.reply_error(status.error());
  exchange.reply_json(200, encode_hit_lists(lists, totals, description.details, description.terms,
                                            query.fields, query.layout));
}

void count(Exchange& exchange, const Service& service) {
  const auto scene = admit_scene_query(exchange, service);
  RayQuery query;
  std::optional<KeptSides> kept;
  if (!scene ||
      !read_rays(exchange, service, {.has_fields = false, .has_crossings = true}, query) ||
      !read_filter(exchange, *scene, query.filter, kept)) {
    return;
  }
  Column<std::uint64_t> totals;
  if (Status status = service.engine.count(*scene, query.rays, query.crossings, service.deadline(),
                                           totals, pointer(kept));
      !status) {
    return exchange.reply_error(status.error());
  }
  exchange.reply_json(200, encode_counts(totals));
}

}  // namespace

void add_ray_routes(Router& router, const Service& service) {
  router.add("POST", "/v1/scenes/{id}/rays:closest",
             [&service](Exchange& exchange) { closest(exchange, service); });
  router.add("POST", "/v1/scenes/{id}/rays:any",
             [&service](Exchange& exchange) { any(exchange, service); });
  router.add("POST", "/v1/scenes/{id}/rays:all",
             [&service](Exchange& exchange) { all(exchange, service); });
  router.add("POST", "/v1/scenes/{id}/rays:count",
             [&service](Exchange& exchange) { count(exchange, service); });
}

}  // namespace sightline
