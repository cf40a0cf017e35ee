#pragma once
/// Router: finds the handler for a method and a path.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/exchange.h"

namespace sightline {

/// Compares paths segment by segment, after percent-decoding each, so that an encoded slash in a
/// name does not divide a path. All routes are added first; then dispatch() may run on several
/// threads at once.
class Router {
 public:
  /// Answers a request; called on several threads at once.
  using Handler = std::function<void(Exchange&)>;

  /// kTaken: the handler reads query parameters. kRefused: any parameter is answered with 422
  /// QUERY_INVALID.
  enum class Parameters { kRefused, kTaken };
  /// Adds a route. GET also answers HEAD. Of several routes that match, the first added is used.
  /// pattern  "/v1/scenes/{id}/rays:closest": literal segments, and {id}, {node} and {job} for any
  ///          segment that is not empty
  void add(std::string_view method, std::string_view pattern, Handler handler,
           Parameters parameters = Parameters::kRefused);

  /// Calls the handler of a request, after it has set scene_id, node_id, job_id and route of the
  /// exchange. Without a handler answers 404 ROUTE_NOT_FOUND, 405 METHOD_NOT_ALLOWED with Allow, or
  /// for OPTIONS 204 with Allow. Exceptions of the handler pass through.
  void dispatch(Exchange& exchange) const;

 private:
  struct Route {
    std::string method, pattern;
    std::vector<std::string> segments;
    Handler handler;
    Parameters parameters;
  };
  std::vector<Route> routes_;
};

/// Splits the path of a request target into decoded segments: "/a/b%20c?x" gives "a", "b c".
/// Returns false, with unspecified `segments`, if it is no path, or a percent sign is not followed
/// by two hexadecimal digits.
bool split_path(std::string_view target, std::vector<std::string>& segments);

}  // namespace sightline
