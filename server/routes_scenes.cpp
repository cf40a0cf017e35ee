#include <algorithm>
#include <charconv>
#include <string_view>

#include "core/store/scene_id.h"
#include "server/request_body.h"
#include "server/routes.h"
#include "server/scene_json.h"

namespace sightline {
namespace {

void reply_not_found(Exchange& exchange) {
  exchange.reply_problem(404, "SCENE_NOT_FOUND", "there is no scene of this name");
}

void reply_scene(Exchange& exchange, int status, const StoredScene& scene) {
  exchange.reply_json(status, encode_scene(scene));
  if (!scene.etag.empty()) exchange.response.set_header("ETag", '"' + scene.etag + '"');
}

/// ?scene=N, nothing else. Read from the target itself: the library's own reader takes
/// "scene=0;x=1" for scene 1. False after it has answered.
bool read_choice(Exchange& exchange, SceneChoice& choice) {
  constexpr std::string_view kScene = "scene=";
  std::string_view query = exchange.request.target;
  query.remove_prefix(std::min(query.find('?'), query.size()));
  while (!query.empty()) {
    query.remove_prefix(1);  // the '?' or '&'
    const std::string_view part = query.substr(0, query.find('&'));
    query.remove_prefix(part.size());
    if (part.empty()) continue;
    std::uint32_t number = 0;
    const char* begin = part.data() + std::min(kScene.size(), part.size());
    const char* end = part.data() + part.size();
    const auto [last, error] = std::from_chars(begin, end, number);
    const bool good = part.starts_with(kScene) && error == std::errc() && last == end;
    if (!good || choice.scene) {
      exchange.reply_problem(422, "QUERY_INVALID",
                             "the only query parameter here is scene=N, once, with the number of a "
                             "scene of the file in digits; there is no other separator than &");
      return false;
    }
    choice.scene = number;
  }
  return true;
}

void put_scene(Exchange& exchange, Service& service) {
  SceneChoice choice;
  // What curl says by itself is taken as well: the importer goes by the first bytes in any case,
  // and a browser's form, which could come from another site, cannot PUT.
  if (!admit_media_type(exchange, {"model/gltf-binary", "model/gltf+json"},
                        {"application/octet-stream", kFormMediaType}) ||
      !admit_body(exchange, service.limits.scene_bytes) || !read_choice(exchange, choice)) {
    return;
  }
  // Before the body, so that nobody uploads a gigabyte to a bad name.
  if (!is_scene_id(exchange.scene_id)) return exchange.reply_error(scene_id_invalid());
  auto upload = service.store.begin_upload();
  if (!upload) return exchange.reply_error(upload.error());
  if (!read_body(exchange, service.limits.scene_bytes, [&](std::span<const char> piece) {
        return upload->append(std::as_bytes(piece));
      })) {
    return;
  }
  auto put = service.store.put(exchange.scene_id, std::move(*upload), choice);
  if (!put) return exchange.reply_error(put.error());
  reply_scene(exchange, put->created ? 201 : 200, *put->scene);
  exchange.response.set_header("Location", "/v1/scenes/" + exchange.scene_id);
}

void get_scene(Exchange& exchange, const Service& service) {
  const SceneSnapshot scene = service.store.find(exchange.scene_id);
  if (!scene) return reply_not_found(exchange);
  reply_scene(exchange, 200, *scene);
}

void delete_scene(Exchange& exchange, Service& service) {
  Status removed = service.store.remove(exchange.scene_id);
  if (removed) return exchange.reply_empty(204);
  exchange.reply_error(removed.error());
  if (removed.error().kind == ErrorKind::kConflict) {
    exchange.response.set_header("Retry-After", "1");
  }
}

}  // namespace

void add_scene_routes(Router& router, Service& service) {
  router.add("GET", "/v1/scenes", [&service](Exchange& exchange) {
    exchange.reply_json(200, encode_scene_list(service.store.list()));
  });
  router.add("GET", "/v1/scenes/{id}",
             [&service](Exchange& exchange) { get_scene(exchange, service); });
  router.add("PUT", "/v1/scenes/{id}",
             [&service](Exchange& exchange) { put_scene(exchange, service); });
  router.add("DELETE", "/v1/scenes/{id}",
             [&service](Exchange& exchange) { delete_scene(exchange, service); });
}

}  // namespace sightline
