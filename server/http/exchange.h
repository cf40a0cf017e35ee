#pragma once
/// One request and the answer to it, as a route sees them.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "core/query/query_work.h"
#include "proto/problem.h"
#include "server/http/http_message.h"
#include "server/http/request_head.h"

namespace sightline {

class BodyReader;
class RequestMemory;

struct Exchange {
  const RequestHead& head;
  HttpResponse& response;
  BodyReader* body;          ///< null where no body can be
  const CancelFlag* caller;  ///< set when nobody waits for the answer any more; may be null
  RequestMemory* memory;     ///< null where nobody counts it
  std::string request_id;
  std::string scene_id = {};  ///< the {id} of the path, percent-decoded, not checked
  std::string node_id = {};   ///< the {node} of the path, likewise
  // For the metrics: the pattern of the route, which outlives this, and what was asked.
  std::string_view route = {};
  std::uint64_t rays = 0, boxes = 0;
  QueryWork work = {};
  std::string problem_code = {};  ///< of the problem that it was answered with
  /// The event loop tries to answer, and must not wait. A request that takes longer, or needs memory
  /// or trees, is put off to a worker, which begins again.
  bool on_event_loop = false;
  /// When the event loop had received the request. The time in a queue counts.
  std::chrono::steady_clock::time_point asked_at = std::chrono::steady_clock::now();
  /// Whether this call of the handler answers nothing: the request is answered by a later one. So
  /// it is where others had the memory: it begins again when its turn comes.
  bool is_put_off() const;
  /// Whether a refusal for want of memory may still be put off.
  bool may_repeat = false;
  /// The answer is a stream, which counts its memory itself.
  bool streams = false;
  /// Whether the client asks for an answer of this type, and of no other.
  bool wants(std::string_view media_type) const { return head.accept == media_type; }

  /// To be asked before much memory is taken for this answer. Errors: see RequestMemory.
  Status reserve(std::uint64_t bytes) const;

  /// media_type  a literal
  void reply(int status, std::string content, std::string_view media_type);
  void reply_json(int status, std::string content) {
    reply(status, std::move(content), "application/json");
  }
  void reply_empty(int status);
  /// Sends what `next` sends, piece by piece, until it returns false. It is called on a thread for
  /// streams, and may wait. `send` is false when the client is gone. Precondition:
  /// BodyReader::may_wait.
  using Send = HttpResponse::Send;
  void reply_stream(std::string_view media_type, std::function<bool(const Send& send)> next);
  /// Of too much at once (kBusy) it also says when to try again.
  void reply_error(const Error& error);
  void reply_problem(int status, std::string_view code, std::string detail);
  void reply_problem(Problem problem);
};

/// What the client gave as X-Request-Id when it is_plain_name and no secret, else a new one: 16
/// hexadecimal digits.
std::string checked_request_id(const std::string& given, const IsSecret& is_secret);

}  // namespace sightline
