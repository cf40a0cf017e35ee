#pragma once
/// Functions that add the routes to a router, in groups. The service must outlive the router, and
/// so must everything that ServerFacts and Journal refer to; these two themselves are copied.

#include "server/http/http_limits.h"
#include "server/http/router.h"
#include "server/operation/request_log.h"
#include "server/service/service.h"
#include "server/sources/scene_sources.h"

namespace sightline {

/// Makes a handler that calls handler(exchange, service). Each route is added by a call with a
/// literal method and path, because tests/laws/room_laws.py reads them from the source.
template <class Service, class Handler>
auto with(Service& service, Handler handler) {
  return [&service, handler](Exchange& exchange) { handler(exchange, service); };
}

/// The last argument of Router::add for a route that reads query parameters.
inline constexpr Router::Parameters kParameters = Router::Parameters::kTaken;

/// Data that /version and /metrics show in addition to the service.
struct ServerFacts {
  const Metrics& metrics;
  const HttpLimits& http;
  const SourceRules& sources;
  /// counts of the other parts; called on several threads at once
  std::function<ServerNow()> now = [] { return ServerNow{}; };
};

// docs/reference/routes.md lists the routes. Each group is a file routes_*.cpp.

/// Health, metrics and version.
void add_health_routes(Router& router, const Service& service, const ServerFacts& facts);
/// The pages, the documents, and the OpenAPI document.
void add_page_routes(Router& router);
/// Loading, listing and deleting scenes. `sources`: what clients may load from; not null.
void add_scene_routes(Router& router, Service& service,
                      const std::shared_ptr<const SourceRules>& sources);
/// Questions about rays. `journal` records the ends of streams.
void add_ray_routes(Router& router, const Service& service, const Journal& journal);
/// Questions about points.
void add_point_routes(Router& router, const Service& service);
/// Parts of a scene: nodes, triangles, geometry, trees; and the self-check.
void add_scene_part_routes(Router& router, const Service& service);
/// Clearance between two selections.
void add_clearance_routes(Router& router, const Service& service);
/// Questions about moving spheres and boxes.
void add_sweep_routes(Router& router, const Service& service);
/// Changes of a node.
void add_node_routes(Router& router, Service& service);
/// Visibility between points.
void add_visibility_routes(Router& router, const Service& service);
/// Questions about boxes, spheres, capsules and convex polyhedra such as frustums.
void add_box_routes(Router& router, const Service& service);

}  // namespace sightline

// Tests: tests/integration/openapi_test.py
