#include "core/run/visibility.h"
#include "proto/visibility_json.h"
#include "server/hit_terms.h"
#include "server/ray_request.h"
#include "server/routes.h"

namespace sightline {
namespace {

void visible(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  VisibilityQuery query;
  if (!request.read_json([&](std::string& body, RayQuery& options) -> Status {
        auto decoded = decode_visibility(body, service.limits.rays);
        if (!decoded) return decoded.error();
        query = std::move(*decoded);
        options = query.options;
        exchange.rays = query.pairs.size();
        return success();
      })) {
    return;
  }
  Column<std::uint8_t> visible;
  HitBatch hits;
  HitBatch* blockers = query.first_blocker ? &hits : nullptr;
  if (!request.went_well(visibility(service.engine, request.scene(), query.pairs,
                                    request.deadline(), request.options(), visible, blockers))) {
    return;
  }
  request.add_time(&WorkReport::trace_us);
  HitDescription about;
  if (blockers != nullptr) {
    RayBatch rays;
    for (std::size_t i = 0; i < hits.size(); ++i) rays.push_back(query.pairs.ray(i));
    if (!request.went_well(describe_hits(service.engine, request.scene(), rays, hits,
                                         query.options.fields, false, request.deadline(), about))) {
      return;
    }
    request.add_time(&WorkReport::describe_us);
  }
  request.reply(encode_visibility(query, visible, blockers, about.details, about.terms));
}

}  // namespace

void add_visibility_routes(Router& router, const Service& service) {
  router.add("POST", "/v1/scenes/{id}/visibility",
             [&service](Exchange& exchange) { visible(exchange, service); });
}

}  // namespace sightline
