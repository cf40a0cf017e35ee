#pragma once
/// The routes, in groups. Each adds its own to the router; the service outlives the router.

#include "server/http/door_limits.h"
#include "server/http/router.h"
#include "server/operation/request_log.h"
#include "server/service/service.h"
#include "server/sources/scene_sources.h"

namespace sightline {

/// A handler that is given the service. Each route is added by a call that names its method and
/// path: room_laws reads them.
template <class Service, class Handler>
auto with(Service& service, Handler handler) {
  return [&service, handler](Exchange& exchange) { handler(exchange, service); };
}

/// Of a route that reads query parameters.
inline constexpr Router::Parameters kParameters = Router::Parameters::kTaken;

/// What /version and /metrics show beside the service.
struct ServerFacts {
  const Metrics& metrics;
  const DoorLimits& door;
  const SourceRules& sources;
  std::function<ServerNow()> now = [] { return ServerNow{}; };
};

/// GET /healthz /readyz /metrics /version
void add_health_routes(Router& router, const Service& service, const ServerFacts& facts);
/// GET / /learn /status /docs, the documents at /docs/.., what these pages load, GET /openapi.json
void add_page_routes(Router& router);
/// PUT GET HEAD DELETE /v1/scenes/{id}, GET /v1/scenes/{id}/events and stats, GET POST /v1/scenes
void add_scene_routes(Router& router, Service& service,
                      const std::shared_ptr<const SourceRules>& sources);
/// POST /v1/rays:generate, /v1/scenes/{id}/rays:closest, rays:any, rays:all and rays:count
void add_ray_routes(Router& router, const Service& service, const Journal& journal);
/// POST /v1/scenes/{id}/points:inside, points:closest, points:nearest and points:distance
void add_point_routes(Router& router, const Service& service);
/// GET /v1/scenes/{id}/nodes, triangles, geometry, bvh and selfcheck
void add_scene_part_routes(Router& router, const Service& service);
/// POST /v1/scenes/{id}/clearance
void add_clearance_routes(Router& router, const Service& service);
/// POST /v1/scenes/{id}/sweeps:closest and sweeps:any
void add_sweep_routes(Router& router, const Service& service);
/// PATCH /v1/scenes/{id}/nodes/{node}
void add_node_routes(Router& router, Service& service);
/// POST /v1/scenes/{id}/visibility
void add_visibility_routes(Router& router, const Service& service);
/// POST /v1/rays-boxes, /v1/scenes/{id}/boxes:any, boxes:list and boxes:count
void add_box_routes(Router& router, const Service& service);

}  // namespace sightline
