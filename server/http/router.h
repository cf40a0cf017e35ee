#pragma once
/// From method and path to a handler.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/exchange.h"

namespace sightline {

/// Paths are compared segment by segment after percent-decoding each, so that an encoded slash in
/// a name never becomes a path.
class Router {
 public:
  using Handler = std::function<void(Exchange&)>;

  /// pattern  "/v1/scenes/{id}/rays:closest": literal segments, and {id} and {node} for any segment
  ///          that is not empty.
  /// GET answers HEAD as well.
  /// parameters  whether the handler reads query parameters; else each is 422 QUERY_INVALID
  enum class Parameters { kRefused, kTaken };
  void add(std::string_view method, std::string_view pattern, Handler handler,
           Parameters parameters = Parameters::kRefused);

  /// Calls the handler. Without one: 404 ROUTE_NOT_FOUND, 405 METHOD_NOT_ALLOWED with Allow, 204
  /// with Allow for OPTIONS.
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

/// The segments of a request target without its query: "/a/b%20c?x" gives "a", "b c". False where
/// it is no path, or a percent sign is not followed by two hexadecimal digits.
bool split_path(std::string_view target, std::vector<std::string>& segments);

}  // namespace sightline
