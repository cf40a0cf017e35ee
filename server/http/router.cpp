#include "server/http/router.h"

#include <algorithm>
#include <utility>

#include "server/http/ascii.h"
#include "server/http/query_parameters.h"

namespace sightline {
namespace {

constexpr std::size_t kUsualSegments = 6;
constexpr std::string_view kScene = "{id}", kNode = "{node}", kJob = "{job}";

bool is_name(std::string_view segment) { return segment.starts_with('{'); }

bool matches(const std::vector<std::string>& pattern, const std::vector<std::string>& path,
             Exchange& exchange) {
  if (pattern.size() != path.size()) return false;
  // Most routes differ in the last segment.
  for (std::size_t i = pattern.size(); i-- > 0;) {
    if (is_name(pattern[i]) ? path[i].empty() : pattern[i] != path[i]) return false;
  }
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] == kScene) exchange.scene_id = path[i];
    if (pattern[i] == kNode) exchange.node_id = path[i];
    if (pattern[i] == kJob) exchange.job_id = path[i];
  }
  return true;
}

}  // namespace

bool split_path(std::string_view target, std::vector<std::string>& segments) {
  segments.clear();
  target = target.substr(0, target.find('?'));
  if (target.empty() || target.front() != '/') return false;
  segments.reserve(kUsualSegments);
  while (!target.empty()) {
    target.remove_prefix(1);
    const std::size_t end = std::min(target.find('/'), target.size());
    if (!decode_percent(target.substr(0, end), segments.emplace_back())) return false;
    target.remove_prefix(end);
  }
  return true;
}

void Router::add(std::string_view method, std::string_view pattern, Handler handler,
                 Parameters parameters) {
  Route route{std::string(method), std::string(pattern), {}, std::move(handler), parameters};
  split_path(pattern, route.segments);
  routes_.push_back(std::move(route));
}

void Router::dispatch(Exchange& exchange) const {
  std::vector<std::string> path;
  const bool is_path = split_path(exchange.head.target, path);
  const std::string& method = exchange.head.method;
  std::string allowed;
  for (const Route& route : routes_) {
    if (!is_path || !matches(route.segments, path, exchange)) continue;
    if (route.method == method || (route.method == "GET" && method == "HEAD")) {
      exchange.route = route.pattern;
      if (route.parameters == Parameters::kRefused && !QueryParameters::read(exchange, {})) return;
      return route.handler(exchange);
    }
    allowed += (allowed.empty() ? "" : ", ") + route.method;
    if (route.method == "GET") allowed += ", HEAD";
  }
  if (allowed.empty()) {
    return exchange.reply_problem(404, "ROUTE_NOT_FOUND",
                                  "there is nothing at this path; /docs lists the paths");
  }
  allowed += ", OPTIONS";
  if (method == "OPTIONS") {
    exchange.reply_empty(204);
  } else {
    exchange.reply_problem(405, "METHOD_NOT_ALLOWED", "this path allows " + allowed);
  }
  exchange.response.set_header("Allow", allowed);
}

}  // namespace sightline
