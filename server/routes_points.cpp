#include "core/run/inside.h"
#include "proto/inside_json.h"
#include "server/ray_request.h"
#include "server/routes.h"

namespace sightline {
namespace {

void inside(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  InsideQuery query;
  if (!request.read_json([&](std::string& body, RayQuery& options) -> Status {
        auto decoded = decode_inside(body, service.limits.rays);
        if (!decoded) return decoded.error();
        query = std::move(*decoded);
        options = query.options;
        exchange.rays = query.points.size();
        return success();
      })) {
    return;
  }
  InsideAnswers answers;
  const InsideMethod method = query.by_winding ? InsideMethod::kWinding : InsideMethod::kParity;
  if (!request.went_well(points_inside(service.engine, request.scene(), query.points, method,
                                       request.deadline(), request.options(), answers))) {
    return;
  }
  request.add_time(&WorkReport::trace_us);
  request.reply(
      encode_inside(query, answers.inside, answers.on_surface, answers.reliable, answers.winding));
}

}  // namespace

void add_point_routes(Router& router, const Service& service) {
  router.add("POST", "/v1/scenes/{id}/points:inside",
             [&service](Exchange& exchange) { inside(exchange, service); });
}

}  // namespace sightline
