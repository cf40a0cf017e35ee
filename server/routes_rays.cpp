#include "proto/hit_binary.h"
#include "proto/hit_json.h"
#include "proto/ray_binary.h"
#include "proto/ray_columns.h"
#include "server/hit_terms.h"
#include "server/ray_request.h"
#include "server/request_body.h"
#include "server/routes.h"

namespace sightline {
namespace {

void closest(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  if (!request.read({})) return;
  const RayQuery& query = request.query();
  HitBatch hits;
  if (!request.went_well(service.engine.closest(request.scene(), query.rays, request.deadline(),
                                                hits, request.options()))) {
    return;
  }
  request.add_time(&WorkReport::trace_us);
  HitDescription about;
  if (!request.went_well(describe_hits(service.engine, request.scene(), query.rays, hits,
                                       query.fields, query.normalize, request.deadline(), about))) {
    return;
  }
  request.add_time(&WorkReport::describe_us);
  request.reply(
      request.is_binary()
          ? encode_hits_binary(hits, about.details, about.terms, query.fields, request.invalid())
          : encode_hits(hits, about.details, about.terms, query.fields, query.layout));
}

void any(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  if (!request.read({.has_fields = false})) return;
  Column<std::uint8_t> occluded;
  if (!request.went_well(service.engine.any(request.scene(), request.query().rays,
                                            request.deadline(), occluded, request.options()))) {
    return;
  }
  request.add_time(&WorkReport::trace_us);
  request.reply(request.is_binary() ? encode_occlusion_binary(occluded, request.invalid())
                                    : encode_occlusion(occluded));
}

void all(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  if (!request.read({.has_crossings = true, .has_max_hits = true})) return;
  const RayQuery& query = request.query();
  HitLists lists;
  Column<std::uint64_t> totals;
  if (!request.went_well(service.engine.all(request.scene(), query.rays, query.crossings,
                                            query.max_hits, service.limits.hits, request.deadline(),
                                            lists, totals, request.options()))) {
    return;
  }
  request.add_time(&WorkReport::trace_us);
  HitDescription about;
  const bool needs_rays = query.normalize || query.fields.has(HitField::kDistance) ||
                          query.fields.has_any_of(kDetailFields);
  if (!request.went_well(describe_hits(service.engine, request.scene(),
                                       needs_rays ? rays_of_hits(query.rays, lists) : RayBatch(),
                                       lists.hits, query.fields, query.normalize,
                                       request.deadline(), about))) {
    return;
  }
  request.add_time(&WorkReport::describe_us);
  request.reply(request.is_binary()
                    ? encode_hit_lists_binary(lists, totals, about.details, about.terms,
                                              query.fields, request.invalid())
                    : encode_hit_lists(lists, totals, about.details, about.terms, query.fields,
                                       query.layout));
}

void count(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  if (!request.read({.has_fields = false, .has_crossings = true})) return;
  Column<std::uint64_t> totals;
  if (!request.went_well(service.engine.count(request.scene(), request.query().rays,
                                              request.query().crossings, request.deadline(), totals,
                                              request.options()))) {
    return;
  }
  request.add_time(&WorkReport::trace_us);
  request.reply(request.is_binary() ? encode_counts_binary(totals, request.invalid())
                                    : encode_counts(totals));
}

/// No scene: the rays themselves.
void generate(Exchange& exchange, const Service& service) {
  std::string body;
  if (!admit_query_type(exchange) || !admit_body(exchange, service.limits.query_bytes) ||
      !read_body(exchange, service.limits.query_bytes, kRayJsonPadding, body)) {
    return;
  }
  const auto query =
      decode_rays(body, {.max_rays = service.limits.rays, .has_fields = false, .has_scene = false});
  if (!query) return exchange.reply_error(query.error());
  exchange.rays = query->rays.size();
  if (exchange.request.get_header_value("Accept") == kBinaryMediaType) {
    return exchange.reply(200, encode_rays_binary(query->rays), kBinaryMediaType);
  }
  exchange.reply_json(200, encode_ray_columns(query->rays));
}

}  // namespace

void add_ray_routes(Router& router, const Service& service) {
  router.add("POST", "/v1/rays:generate",
             [&service](Exchange& exchange) { generate(exchange, service); });
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
