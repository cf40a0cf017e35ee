#include "core/store/scene_id.h"
#include "proto/json/load_json.h"
#include "server/http/body_reader.h"
#include "server/http/http_status.h"
#include "server/http/media_type.h"
#include "server/http/request_body.h"
#include "server/routes/preconditions.h"
#include "server/routes/routes.h"
#include "server/routes/scene_admission.h"
#include "server/routes/scene_events.h"
#include "server/routes/scene_parameters.h"
#include "server/service/scene_json.h"
#include "server/service/scene_stats.h"

namespace sightline {
namespace {

/// A scene in the list of all, as JSON that is built and printed.
constexpr std::uint64_t kListedBytes = 2048;

void reply_scene(Exchange& exchange, const StoredScene& scene) {
  if (!went_well(exchange, exchange.reserve(bytes_of_scene(scene)))) return;
  exchange.reply_json(200, encode_scene(scene));
  if (!scene.etag.empty()) exchange.response.set_header("ETag", '"' + scene.etag + '"');
}

/// The load goes on without the client, which is told where to ask.
void reply_accepted(Exchange& exchange, const Service& service, const std::string& id) {
  const SceneSnapshot scene = service.store.find(id);
  if (scene) {
    exchange.reply_json(202, text_within(exchange, *scene));
  } else {
    exchange.reply_json(202, "{\"id\":\"" + id + "\"}\n");  // removed in the meantime
  }
  exchange.response.set_header("Location", "/v1/scenes/" + id);
  exchange.response.set_header("Retry-After", "1");
}

Deadline wait_of(const Exchange& exchange, const Service& service, std::chrono::milliseconds wait) {
  Deadline deadline = Deadline::in(wait, &service.cancelled);
  deadline.caller = exchange.caller;
  return deadline;
}

/// A place to wait at; none where there is no time to wait, or no place.
Permit permit_wait(Service& service, const Deadline& deadline) {
  return deadline.passed() ? Permit() : service.waiters.try_acquire();
}

/// Answers with the outcome of the load if it comes in time, else with 202.
void finish_load(Exchange& exchange, Service& service, SceneLoad& load, const Permit& permit,
                 const Deadline& deadline) {
  const auto put = permit ? service.store.wait(load, deadline) : std::nullopt;
  if (!put) return reply_accepted(exchange, service, load.id());
  if (!*put) {
    const Error& error = put->error();
    // What a file without its line ends and zero bytes leads to.
    const bool is_damaged = error.code == "GLTF_CONTAINER_INVALID" ||
                            error.code == "GLTF_JSON_INVALID" ||
                            error.code == "GLTF_VERSION_UNSUPPORTED";
    return exchange.reply_error(is_damaged ? with_form_hint(exchange, error, "") : error);
  }
  reply_done(exchange, (*put)->created ? 201 : 200, *(*put)->scene);
  exchange.response.set_header("Location", "/v1/scenes/" + load.id());
}

/// What can be known before the new content is there: it is decided then, and what is on its way to
/// the name may have come by that time.
Status check_now(const Service& service, const std::string& id, const Precondition& precondition) {
  if (service.store.is_shared()) return success();  // another server may know a newer content
  const SceneSnapshot scene = service.store.find(id);
  if (scene && scene->is_moving()) return success();
  return precondition.check(scene ? scene->etag : "");
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
  // The decoder of a compressed body cannot be stored: the body is decoded when all of it is here.
  if (exchange.body != nullptr && exchange.body->decodes() &&
      !is_body_here(exchange, service.limits.scene_bytes)) {
    return;
  }
  // Null, where this is the first part of the body.
  std::shared_ptr<IncomingScene> incoming;
  if (exchange.body != nullptr) {
    incoming = std::static_pointer_cast<IncomingScene>(exchange.body->kept());
  }
  if (!incoming) {
    // Before the body, so that nobody uploads a gigabyte to a bad name, nor for nothing.
    Precondition precondition = precondition_of(exchange);
    if (!went_well(exchange, check_now(service, exchange.scene_id, precondition))) return;
    auto begun = service.store.begin(exchange.scene_id, parameters.choice);
    if (!begun) return exchange.reply_error(begun.error());
    incoming = std::make_shared<IncomingScene>(std::move(*begun));
    incoming->demand(std::move(precondition));
    incoming->expect(body_length(exchange).value_or(0));
  }
  const auto append = [&](std::span<const char> piece) {
    return incoming->append(std::as_bytes(piece));
  };
  if (!read_body_in_parts(exchange, service.limits.scene_bytes, incoming, append)) return;
  const Deadline deadline = parameters.wait
                                ? wait_of(exchange, service, *parameters.wait)
                                : Deadline{.flag = &service.cancelled, .caller = exchange.caller};
  const Permit permit = permit_wait(service, deadline);
  const auto load = service.store.submit(std::move(*incoming), static_cast<bool>(permit));
  finish_load(exchange, service, *load, permit, deadline);
}

/// What the operator does not allow is 403, and the other faults of a source what they are.
void reply_source_error(Exchange& exchange, const Error& error) {
  for (const char* code : {"PATH_NOT_ALLOWED", "PATH_REFUSED", "URL_NOT_ALLOWED"}) {
    if (error.code == code) {
      return exchange.reply_problem(make_problem(error, 403, std::string(status_title(403))));
    }
  }
  exchange.reply_error(error);
}

void post_scene(Exchange& exchange, Service& service,
                const std::shared_ptr<const SourceRules>& sources) {
  constexpr std::uint64_t kMostBytes = 64 << 10;
  SceneParameters parameters;
  std::string body;
  if (!admit_json_change(exchange, kMostBytes) ||
      !read_parameters(exchange, KnownParameters::kWait, parameters) ||
      !read_body(exchange, kMostBytes, 0, body)) {
    return;
  }
  const auto request = decode_load_request(body);
  if (!request) return exchange.reply_error(request.error());
  if (!is_scene_id(request->id)) {
    Error error = scene_id_invalid();
    error.pointer = "/id";
    return exchange.reply_error(error);
  }
  auto fetch = fetch_of(*request, sources, service.limits.scene_bytes);
  if (!fetch) return reply_source_error(exchange, fetch.error());
  const Deadline deadline =
      wait_of(exchange, service, parameters.wait.value_or(std::chrono::milliseconds(0)));
  const Permit permit = permit_wait(service, deadline);
  auto load = service.store.fetch(request->id, {request->scene}, std::move(*fetch),
                                  static_cast<bool>(permit));
  if (!load) return exchange.reply_error(load.error());
  finish_load(exchange, service, **load, permit, deadline);
}

void get_scene(Exchange& exchange, Service& service) {
  SceneParameters parameters;
  if (!read_parameters(exchange, KnownParameters::kWait, parameters)) return;
  const Permit permit = parameters.wait ? service.waiters.try_acquire() : Permit();
  const Deadline deadline =
      wait_of(exchange, service, permit ? *parameters.wait : std::chrono::seconds(0));
  if (!obtain_scene(exchange, service, deadline)) return;
  for (;;) {
    const std::uint64_t seen = service.store.changes();
    const SceneSnapshot scene = service.store.find(exchange.scene_id);
    if (!scene) return reply_scene_not_found(exchange, service);
    if (!scene->is_moving() || deadline.passed()) return reply_scene(exchange, *scene);
    service.store.wait_for_change(seen, deadline);
  }
}

void delete_scene(Exchange& exchange, Service& service) {
  const auto removed = service.store.remove(exchange.scene_id, precondition_of(exchange));
  if (!removed) return reply_store_error(exchange, service, removed.error());
  exchange.reply_empty(204);
  // With an origin, a client may require it of other servers.
  if (*removed > 0) {
    exchange.response.set_header("X-Scene-Revision", std::to_string(*removed));
  }
}

}  // namespace

void add_scene_routes(Router& router, Service& service,
                      const std::shared_ptr<const SourceRules>& sources) {
  router.add("GET", "/v1/scenes", [&service](Exchange& exchange) {
    const std::vector<SceneSnapshot> scenes = service.store.list();
    if (!went_well(exchange, exchange.reserve(scenes.size() * kListedBytes))) return;
    exchange.reply_json(200, encode_scene_list(scenes));
  });
  router.add(
      "POST", "/v1/scenes",
      [&service, sources](Exchange& exchange) { post_scene(exchange, service, sources); },
      kParameters);
  router.add("GET", "/v1/scenes/{id}", with(service, get_scene), kParameters);
  router.add("GET", "/v1/scenes/{id}/events", with(service, reply_scene_events));
  router.add("GET", "/v1/scenes/{id}/stats", [&service](Exchange& exchange) {
    const SceneSnapshot scene = admit_scene(exchange, service);
    if (scene) exchange.reply_json(200, encode_stats(*scene));
  });
  router.add("PUT", "/v1/scenes/{id}", with(service, put_scene), kParameters);
  router.add("DELETE", "/v1/scenes/{id}", with(service, delete_scene));
}

}  // namespace sightline
