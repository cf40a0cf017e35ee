#include <nlohmann/json.hpp>

#include "server/operation/version.h"
#include "server/routes/routes.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

void reply_health(Exchange& exchange) { exchange.reply_json(200, "{\"status\":\"ok\"}\n"); }

bool is_quarantined(const StoredScene& scene) {
  return scene.failure && scene.failure->code == "STORE_DAMAGED";
}

/// Which scenes there are, and what an operator should check, for clients that may know.
Json readiness_details(const Service& service, bool stopping, bool settled) {
  std::size_t ready = 0, loading = 0;
  Json failed = Json::array(), quarantined = Json::array(), reasons = Json::array();
  for (const SceneSnapshot& scene : service.store.list()) {
    switch (scene->state) {
      case SceneState::kQueued:
      case SceneState::kLoading:
        ++loading;
        break;
      case SceneState::kReady:
        ++ready;
        break;
      case SceneState::kFailed:
        failed.push_back(scene->id);
        if (is_quarantined(*scene)) quarantined.push_back(scene->id);
        break;
      case SceneState::kStored:
        break;
    }
  }
  if (stopping) reasons.push_back({{"code", "STOPPING"}});
  if (!settled) reasons.push_back({{"code", "SCENES_LOADING"}, {"count", loading}});
  if (!quarantined.empty()) {
    reasons.push_back({{"code", "SCENES_QUARANTINED"}, {"scenes", quarantined}});
  }
  if (service.store.is_full()) reasons.push_back({{"code", "STORE_FULL"}});
  if (service.store.is_failing()) reasons.push_back({{"code", "STORE_IO"}});
  if (service.store.is_origin_failing()) reasons.push_back({{"code", "ORIGIN_UNREACHABLE"}});
  Json details{{"scenes", {{"ready", ready}, {"loading", loading}, {"failed", failed.size()}}}};
  // A scene that failed is its own trouble: the others are served.
  if (!failed.empty()) details["failed"] = failed;
  if (!reasons.empty()) details["reasons"] = reasons;
  return details;
}

void reply_readiness(Exchange& exchange, const Service& service) {
  // Each is read once, so that the status has its reason.
  const bool stopping = service.stopping, settled = service.store.settled();
  const char* status = stopping ? "stopping" : !settled ? "loading" : "ready";
  const bool ready = !stopping && settled;
  Json document{{"status", status}};
  if (exchange.head.access >= Access::kRead)
    document.update(readiness_details(service, stopping, settled));
  exchange.reply_json(ready ? 200 : 503, document.dump() + "\n");
  if (!ready) exchange.response.set_header("Retry-After", "1");
}

void reply_version(Exchange& exchange, const Service& service, const ServerFacts& facts) {
  const Json document{{"name", "sightline"},
                      {"version", version()},
                      {"kernel", service.engine.kernel()},
                      {"kernels", Engine::kernels()},
                      {"threads", service.engine.threads()},
                      {"limits",
                       {{"scene_bytes", service.limits.scene_bytes.get()},
                        {"query_bytes", service.limits.query_bytes.get()},
                        {"rays", service.limits.rays.get()},
                        {"hits", service.limits.hits.get()},
                        {"loads", service.limits.loads},
                        {"waiters", service.limits.waiters},
                        {"streams", facts.http.streams},
                        {"request_ms", service.limits.request.get().count()},
                        {"fetch_ms", facts.sources.urls.time.count()},
                        {"drain_ms", service.limits.drain.get().count()},
                        {"notice_ms", service.limits.notice.get().count()},
                        {"memory_budget", service.limits.memory_budget},
                        {"disk_budget", service.limits.disk_budget},
                        {"cache_bytes", service.store.cache_bytes()},
                        {"workers", facts.http.workers},
                        {"queue", facts.http.queue},
                        {"connections", facts.http.connections.get()},
                        {"header_bytes", facts.http.head.bytes.get()},
                        {"header_fields", facts.http.head.fields.get()},
                        {"header_ms", facts.http.head_time.get().count()},
                        {"idle_ms", facts.http.idle.get().count()},
                        {"spool_bytes", facts.http.spool_bytes},
                        {"memory", facts.http.memory},
                        {"request_memory", facts.http.request},
                        {"rate_bytes_per_second", facts.http.pace.bytes_per_second.get()},
                        {"busy_bytes_per_second", facts.http.busy_rate.get()},
                        {"rate_ms", facts.http.pace.window.get().count()},
                        {"body_ms", facts.http.pace.longest.get().count()}}}};
  exchange.reply_json(200, document.dump() + "\n");
}

}  // namespace

void add_health_routes(Router& router, const Service& service, const ServerFacts& facts) {
  router.add("GET", "/healthz", reply_health);
  router.add("GET", "/readyz", with(service, reply_readiness));
  router.add("GET", "/metrics", [&service, facts](Exchange& exchange) {
    exchange.reply(200, facts.metrics.text(service.store, facts.now()),
                   "text/plain; version=0.0.4; charset=utf-8");
  });
  router.add("GET", "/version",
             [&service, facts](Exchange& exchange) { reply_version(exchange, service, facts); });
}

}  // namespace sightline
