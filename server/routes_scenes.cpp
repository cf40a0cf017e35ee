#include "server/request_body.h"
#include "server/routes.h"
#include "server/scene_events.h"
#include "server/scene_json.h"
#include "server/scene_parameters.h"

namespace sightline {
namespace {

void reply_not_found(Exchange& exchange) {
  exchange.reply_problem(404, "SCENE_NOT_FOUND", "there is no scene of this name");
}

void reply_scene(Exchange& exchange, int status, const StoredScene& scene) {
  exchange.reply_json(status, encode_scene(scene));
  if (!scene.etag.empty()) exchange.response.set_header("ETag", '"' + scene.etag + '"');
}

/// The load goes on without the client, who is told where to look.
void reply_accepted(Exchange& exchange, const Service& service, const std::string& id) {
  const SceneSnapshot scene = service.store.find(id);
  if (scene) {
    exchange.reply_json(202, encode_scene(*scene));
  } else {
    exchange.reply_json(202, "{\"id\":\"" + id + "\"}\n");  // removed in the meantime
  }
  exchange.response.set_header("Location", "/v1/scenes/" + id);
  exchange.response.set_header("Retry-After", "1");
}

/// Answers with the outcome of the load if it comes in time, else with 202.
void finish_load(Exchange& exchange, Service& service, IncomingScene incoming,
                 const Deadline& deadline) {
  const Claim claim = deadline.passed() ? Claim() : service.waiters.claim();
  const bool waits = static_cast<bool>(claim);
  const auto load = service.store.submit(std::move(incoming), waits);
  const auto put = waits ? service.store.wait(*load, deadline) : std::nullopt;
  if (!put) return reply_accepted(exchange, service, load->id());
  if (!*put) return exchange.reply_error(put->error());
  reply_scene(exchange, (*put)->created ? 201 : 200, *(*put)->scene);
  exchange.response.set_header("Location", "/v1/scenes/" + load->id());
}

Deadline deadline_of(const Service& service, std::chrono::milliseconds wait) {
  return Deadline::in(wait, &service.cancelled);
}

void put_scene(Exchange& exchange, Service& service) {
  SceneParameters parameters;
  // What curl says by itself is taken as well: the importer goes by the first bytes in any case,
  // and a browser's form, which could come from another site, cannot PUT.
  if (!admit_media_type(exchange, {"model/gltf-binary", "model/gltf+json"},
                        {"application/octet-stream", kFormMediaType}) ||
      !admit_body(exchange, service.limits.scene_bytes) ||
      !read_parameters(exchange, KnownParameters::kSceneAndWait, parameters)) {
    return;
  }
  // Before the body, so that nobody uploads a gigabyte to a bad name.
  auto incoming = service.store.begin(exchange.scene_id, parameters.choice);
  if (!incoming) return exchange.reply_error(incoming.error());
  incoming->expect(body_length(exchange).value_or(0));
  if (!read_body(exchange, service.limits.scene_bytes, [&](std::span<const char> piece) {
        return incoming->append(std::as_bytes(piece));
      })) {
    return;
  }
  finish_load(exchange, service, std::move(*incoming),
              parameters.wait ? deadline_of(service, *parameters.wait)
                              : Deadline{.flag = &service.cancelled});
}

void get_scene(Exchange& exchange, Service& service) {
  SceneParameters parameters;
  if (!read_parameters(exchange, KnownParameters::kWait, parameters)) return;
  const Claim claim = parameters.wait ? service.waiters.claim() : Claim();
  const Deadline deadline =
      deadline_of(service, claim ? *parameters.wait : std::chrono::seconds(0));
  for (;;) {
    const std::uint64_t seen = service.store.changes();
    const SceneSnapshot scene = service.store.find(exchange.scene_id);
    if (!scene) return reply_not_found(exchange);
    if (!scene->is_moving() || deadline.passed()) return reply_scene(exchange, 200, *scene);
    service.store.wait_for_change(seen, deadline);
  }
}

void delete_scene(Exchange& exchange, Service& service) {
  Status removed = service.store.remove(exchange.scene_id);
  if (!removed) return exchange.reply_error(removed.error());
  exchange.reply_empty(204);
}

}  // namespace

void add_scene_routes(Router& router, Service& service) {
  router.add("GET", "/v1/scenes", [&service](Exchange& exchange) {
    exchange.reply_json(200, encode_scene_list(service.store.list()));
  });
  router.add("GET", "/v1/scenes/{id}",
             [&service](Exchange& exchange) { get_scene(exchange, service); });
  router.add("GET", "/v1/scenes/{id}/events",
             [&service](Exchange& exchange) { reply_scene_events(exchange, service); });
  router.add("PUT", "/v1/scenes/{id}",
             [&service](Exchange& exchange) { put_scene(exchange, service); });
  router.add("DELETE", "/v1/scenes/{id}",
             [&service](Exchange& exchange) { delete_scene(exchange, service); });
}

}  // namespace sightline
