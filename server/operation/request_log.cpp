#include "server/operation/request_log.h"

#include "core/store/scene_id.h"
#include "server/access/key_ring.h"

namespace sightline {
namespace {

/// A path is the client's text, and may be anything, a key too: shown is the route, with the name
/// of the scene where it could be one.
std::string shown_path(const Exchange& exchange) {
  std::string path(exchange.route);
  if (exchange.head.hides_path) return path;
  const std::size_t place = path.find("{id}");
  if (place != std::string::npos && is_scene_id(exchange.scene_id) &&
      !holds_key(exchange.scene_id)) {
    path.replace(place, 4, exchange.scene_id);
  }
  return path;
}

/// Counts a body that a worker has waited for in vain. The event loop counts its own.
constexpr std::string_view kTooSlow = "REQUEST_TIMEOUT";

/// What an operator should see without asking for every request. 503 is how a server says that it
/// has enough to do.
Log::Level level_of(int status) {
  return status >= 500 && status != 503 ? Log::Level::warn : Log::Level::debug;
}

}  // namespace

void note_request(const Journal& journal, const Exchange& exchange, int status,
                  std::chrono::duration<double> time) {
  journal.metrics.count({exchange.head.method, exchange.route, status, time, exchange.rays,
                         exchange.boxes, exchange.work});
  if (exchange.problem_code == kTooSlow) journal.metrics.count_slow();
  const Log::Level level = level_of(status);
  if (!journal.log.shows(level)) return;
  journal.log.write(level, "request",
                    {{"method", known_method(exchange.head.method)},
                     {"path", shown_path(exchange)},
                     {"status", std::int64_t{status}},
                     {"code", exchange.problem_code},
                     {"bytes", std::uint64_t{exchange.response.body.size()}},
                     {"ms", time.count() * 1000},
                     {"id", exchange.request_id},
                     {"key", exchange.head.key_name}});
}

StreamNote::StreamNote(const Exchange& exchange)
    : path(shown_path(exchange)),
      request_id(exchange.request_id),
      key_name(exchange.head.key_name) {}

void note_stream_end(const Journal& journal, const StreamNote& stream) {
  if (stream.code == kTooSlow) journal.metrics.count_slow();
  const Log::Level level = stream.code.empty() ? Log::Level::debug : Log::Level::info;
  if (!journal.log.shows(level)) return;
  const std::chrono::duration<double, std::milli> time =
      std::chrono::steady_clock::now() - stream.begin;
  journal.log.write(level, stream.code.empty() ? "stream ended" : "stream broken off",
                    {{"path", stream.path},
                     {"code", stream.code},
                     {"rays", stream.rays},
                     {"bytes", stream.bytes},
                     {"ms", time.count()},
                     {"id", stream.request_id},
                     {"key", stream.key_name}});
}

void note_refusal(const Journal& journal, const RequestHead& head, const RequestFault& fault,
                  const std::string& request_id) {
  journal.metrics.count({head.method, "event_loop", fault.status});
  // Attempts with wrong keys should be seen.
  const bool tells = fault.status == 401 || fault.status == 403;
  journal.log.write(tells ? Log::Level::info : Log::Level::debug, "request refused",
                    {{"method", known_method(head.method)},
                     {"status", std::int64_t{fault.status}},
                     {"code", fault.code},
                     {"id", request_id},
                     {"key", head.key_name}});
}

}  // namespace sightline
