#include "server/routes/scene_admission.h"

#include <algorithm>
#include <charconv>

#include "core/base/watch.h"
#include "core/query/similar_names.h"
#include "core/store/scene_id.h"
#include "proto/binary/ray_binary.h"
#include "proto/json/hit_lines.h"
#include "server/access/key_ring.h"
#include "server/http/ascii.h"
#include "server/http/media_type.h"
#include "server/http/request_body.h"
#include "server/http/request_memory.h"
#include "server/service/scene_json.h"

namespace sightline {

bool admit_query_type(Exchange& exchange) {
  return admit_media_type(exchange, {"application/json"}, {kFormMediaType});
}

bool admit_json_change(Exchange& exchange, std::uint64_t most_bytes) {
  if (!says_media_type(exchange)) {
    exchange.reply_problem(415, "MEDIA_TYPE_UNSUPPORTED", "send Content-Type: application/json");
    return false;
  }
  return admit_media_type(exchange, {"application/json"}) && admit_body(exchange, most_bytes);
}

bool read_query_body(Exchange& exchange, const Service& service, std::string& body) {
  const std::uint64_t most = service.limits.query_bytes;
  return admit_query_type(exchange) && admit_body(exchange, most) &&
         read_body(exchange, most, kRayJsonPadding, body);
}

std::optional<QueryType> admit_rays_type(Exchange& exchange, bool takes_lines) {
  const bool good =
      takes_lines
          ? admit_media_type(exchange, {"application/json", kLinesMediaType, kBinaryMediaType},
                             {kFormMediaType})
          : admit_media_type(exchange, {"application/json", kBinaryMediaType}, {kFormMediaType});
  if (!good) return std::nullopt;
  const std::string_view type = media_type(exchange);
  if (equals_caseless(type, kBinaryMediaType)) return QueryType::kBinary;
  return equals_caseless(type, kLinesMediaType) ? QueryType::kLines : QueryType::kJson;
}

void reply_scene_not_found(Exchange& exchange, const Service& service) {
  constexpr std::uint64_t kSteps = std::uint64_t{1} << 16;
  // No answer repeats a key that was pasted into the path. It may be valid elsewhere.
  const bool is_told = is_key_name(exchange.scene_id);
  Error error = is_told ? scene_not_found(exchange.scene_id) : scene_not_found();
  if (is_told) {
    const std::vector<SceneSnapshot> scenes = service.store.list();
    const Deadline deadline = service.deadline();
    DeadlineWatch watch(deadline);
    error.message += similar_names_text(
        exchange.scene_id, scenes.size(),
        [&](std::size_t i) { return std::string_view(scenes[i]->id); }, kSteps, watch);
  }
  exchange.reply_error(error);
}

void reply_store_error(Exchange& exchange, const Service& service, const Error& error) {
  if (error.code == "SCENE_NOT_FOUND") return reply_scene_not_found(exchange, service);
  exchange.reply_error(error);
}

std::optional<SceneSnapshot> obtain_scene(Exchange& exchange, const Service& service,
                                          const Deadline& deadline) {
  std::uint64_t minimum = 0;
  if (const auto& text = exchange.head.min_revision) {
    const char* const end = text->data() + text->size();
    const auto read = std::from_chars(text->data(), end, minimum);
    if (read.ec != std::errc() || read.ptr != end) {
      exchange.reply_problem(400, "REVISION_INVALID",
                             "X-Scene-Min-Revision is a decimal number of at most 64 bits");
      return std::nullopt;
    }
  }
  // The event loop does not wait for an origin: without an answer a worker begins again.
  if (exchange.on_event_loop && !service.store.has(exchange.scene_id, minimum)) return std::nullopt;
  std::optional<Permit> permit;
  if (!service.store.has(exchange.scene_id, minimum)) {
    // Other scenes are answered while an origin is slow.
    permit.emplace(service.waiters.try_acquire());
    if (!*permit) {
      exchange.reply_error(
          {ErrorKind::kBusy, "ORIGIN_BUSY", "many requests wait for scenes of the origin", ""});
      return std::nullopt;
    }
  }
  auto stored = service.store.obtain(exchange.scene_id, minimum, deadline);
  if (!stored) {
    exchange.reply_error(stored.error());
    return std::nullopt;
  }
  if (!*stored) {
    reply_scene_not_found(exchange, service);
    return std::nullopt;
  }
  return *std::move(stored);
}

SceneSnapshot admit_scene(Exchange& exchange, const Service& service) {
  const auto obtained = obtain_scene(exchange, service, service.deadline());
  if (!obtained) return nullptr;
  const SceneSnapshot& stored = *obtained;
  switch (stored->state) {
    case SceneState::kReady:
      // Which of the contents that this name has had gave the answer.
      exchange.response.set_header("X-Scene-Revision", std::to_string(stored->revision));
      return stored;
    case SceneState::kFailed:
      exchange.reply_problem(409, "SCENE_FAILED",
                             "the scene could not be loaded: " + stored->failure->message);
      return nullptr;
    case SceneState::kQueued:
    case SceneState::kLoading:
    case SceneState::kStored:
      exchange.reply_problem(409, "SCENE_LOADING", "the scene is still loading");
      exchange.response.set_header("Retry-After", "1");
      return nullptr;
  }
  return nullptr;
}

bool went_well(Exchange& exchange, const Status& status) {
  if (!status) exchange.reply_error(status.error());
  return static_cast<bool>(status);
}

Deadline deadline_of(const Exchange& exchange, const Service& service,
                     std::optional<std::uint64_t> timeout_ms, int threads) {
  constexpr std::chrono::microseconds kOnEventLoop{300};
  Deadline deadline = service.deadline();
  // The time in a queue counts for the client, not for what the server spends on the request.
  if (timeout_ms) {
    const auto most = static_cast<std::uint64_t>(service.limits.request.get().count());
    const std::chrono::milliseconds wish(std::min(*timeout_ms, most));
    deadline.at = std::min(deadline.at, exchange.asked_at + wish);
  }
  if (exchange.on_event_loop)
    deadline.at = std::min(deadline.at, Deadline::Clock::now() + kOnEventLoop);
  deadline.caller = exchange.caller;
  deadline.threads = threads;
  deadline.progress = exchange.progress;
  if (exchange.memory != nullptr && !exchange.on_event_loop)
    exchange.memory->wait_until(deadline.at);
  return deadline;
}

std::string text_within(const Exchange& exchange, const StoredScene& scene) {
  const Status status = exchange.reserve(bytes_of_scene(scene));
  return status ? encode_scene(scene) : encode_scene_summary(scene);
}

void reply_done(Exchange& exchange, int status, const StoredScene& scene) {
  exchange.reply_json(status, text_within(exchange, scene));
  if (!scene.etag.empty()) exchange.response.set_header("ETag", '"' + scene.etag + '"');
}

std::shared_ptr<const Scene> admit_scene_query(Exchange& exchange, const Service& service) {
  return admit_query_type(exchange) ? admit_query_of_scene(exchange, service) : nullptr;
}

std::shared_ptr<const Scene> admit_query_of_scene(Exchange& exchange, const Service& service) {
  if (!admit_body(exchange, service.limits.query_bytes)) return nullptr;
  const SceneSnapshot stored = admit_scene(exchange, service);
  return stored ? stored->scene : nullptr;
}

}  // namespace sightline
