#include "server/routes/scene_events.h"

#include <memory>

#include "core/store/scene_id.h"
#include "server/http/body_reader.h"
#include "server/routes/scene_admission.h"
#include "server/service/scene_json.h"

namespace sightline {
namespace {

constexpr std::chrono::milliseconds kLook{250};
/// A client that is gone is noticed by writing to it.
constexpr std::chrono::seconds kHeartbeat{5};
constexpr std::chrono::hours kLongestStream{1};

/// What one listener has been told.
class EventStream {
 public:
  EventStream(const Exchange& exchange, Service& service)
      : id_(exchange.scene_id),
        service_(service),
        caller_(exchange.caller),
        revoked_(exchange.head.revoked) {}

  /// Waits for something to tell, at most until the heartbeat is due. Empty when it was cut off.
  std::string next() {
    for (;;) {
      const std::uint64_t seen = service_.store.changes();
      const bool is_revoked = revoked_ && revoked_->cancelled();
      if (service_.stopping || is_revoked || Clock::now() >= end_) {
        ended_ = true;
        return {};
      }
      std::string event = event_now();
      if (event != told_) {
        told_ = event;
        spoke_ = Clock::now();
        return event;
      }
      if (Clock::now() >= spoke_ + kHeartbeat) {
        spoke_ = Clock::now();
        return ":\n\n";
      }
      Deadline look = Deadline::in(kLook, &service_.cancelled);
      look.caller = caller_;
      if (look.cancelled()) {
        ended_ = true;
        return {};
      }
      service_.store.wait_for_change(seen, look);
    }
  }
  bool ended() const { return ended_; }

 private:
  using Clock = std::chrono::steady_clock;

  std::string event_now() {
    const SceneSnapshot scene = service_.store.find(id_);
    ended_ = !scene || !scene->is_moving();
    if (!scene) return "event: removed\ndata: {\"id\":\"" + id_ + "\"}\n\n";
    const bool failed = scene->failure || (scene->update && scene->update->failure);
    const char* name = !ended_ ? "progress" : failed ? "failed" : "ready";
    return std::string("event: ") + name + "\ndata: " + encode_scene_summary(*scene) + "\n";
  }

  const std::string id_;
  Service& service_;
  const CancelFlag* const caller_;
  const std::shared_ptr<const CancelFlag> revoked_;
  const Clock::time_point end_ = Clock::now() + kLongestStream;
  Clock::time_point spoke_ = Clock::now();
  std::string told_;
  bool ended_ = false;
};

}  // namespace

void reply_scene_events(Exchange& exchange, Service& service) {
  if (!obtain_scene(exchange, service, Deadline::in(std::chrono::seconds(0)))) return;
  if (exchange.body == nullptr || !exchange.body->may_wait()) return;
  const auto stream = std::make_shared<EventStream>(exchange, service);
  exchange.reply_stream("text/event-stream", [stream](const Exchange::Send& send) {
    const std::string text = stream->next();
    return (text.empty() || send(text)) && !stream->ended();
  });
  exchange.response.set_header("X-Accel-Buffering", "no");  // nginx would collect the events
}

}  // namespace sightline
