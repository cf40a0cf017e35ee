#pragma once
/// Exchange: a request and its answer, as a route sees them.

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

/// A request, and functions to answer it. Made for one call of a handler, and used by one thread.
/// `head`, `response`, `body`, `caller` and `memory` are valid until the answer has been written,
/// with a stream until the stream has ended.
struct Exchange {
  const RequestHead& head;
  HttpResponse& response;
  BodyReader* body;           ///< null if there can be no body
  const CancelFlag* caller;   ///< set when the client no longer waits for the answer; may be null
  RequestMemory* memory;      ///< null if memory is not counted
  std::string request_id;     ///< see checked_request_id
  std::string scene_id = {};  ///< the {id} of the path, percent-decoded, not validated
  std::string node_id = {};   ///< the {node} of the path, percent-decoded, not validated
  std::string job_id = {};    ///< the {job} of the path, percent-decoded, not validated
  // For metrics and log: the pattern of the route, which outlives the exchange, and what the
  // request asked for.
  std::string_view route = {};
  std::uint64_t rays = 0, boxes = 0;
  QueryWork work = {};
  std::string problem_code = {};  ///< of the error that was answered
  /// True if the event loop tries to answer, which must not wait. A request that takes longer, or
  /// needs memory or trees, is put off to a worker and begins again there.
  bool on_event_loop = false;
  /// When the event loop had received the request; the time in a queue counts.
  std::chrono::steady_clock::time_point asked_at = std::chrono::steady_clock::now();
  /// True if this call of the handler gives no answer, because a later call will: the request was
  /// put off, or others had the memory and it begins again when its turn comes.
  bool is_put_off() const;
  /// True if an answer of 503 for lack of memory is not sent, and the request begins again.
  bool may_repeat = false;
  /// Set by reply_stream: the answer is a stream, which counts its memory itself.
  bool streams = false;
  /// The body, if it was read before: then `body` is null, and read_body copies this. May be null.
  const std::string* whole_body = nullptr;
  WorkProgress* progress = nullptr;  ///< where it is told how far the work is; may be null
  /// True if this media type is the first that the client lists in Accept, with or without
  /// parameters.
  bool wants(std::string_view media_type) const;

  /// Reserves memory for this answer; to be called before much memory is allocated. Errors: those
  /// of RequestMemory::reserve.
  Status reserve(std::uint64_t bytes) const;

  /// Sets status, body and Content-Type of the answer; headers that were set before stay.
  /// `media_type` must be a literal.
  void reply(int status, std::string content, std::string_view media_type);
  /// Calls reply() with application/json.
  void reply_json(int status, std::string content) {
    reply(status, std::move(content), "application/json");
  }
  /// Sets the status, and an empty body.
  void reply_empty(int status);
  /// Answers 200 with a stream. After the handler has returned, next(send) is called repeatedly on
  /// this thread, where it may wait, until it returns false. send(text) sends a piece and returns
  /// false if the client is gone. Precondition: BodyReader::may_wait.
  using Send = HttpResponse::Send;
  void reply_stream(std::string_view media_type, std::function<bool(const Send& send)> next);
  /// Answers with an error, in the status of its kind (http_status); for kBusy also with
  /// "Retry-After: 1".
  void reply_error(const Error& error);
  /// Answers with application/problem+json [RFC9457]. Sets problem_code, and in the problem the
  /// request id.
  void reply_problem(int status, std::string_view code, std::string detail);
  void reply_problem(Problem problem);
};

/// The client's X-Request-Id `given` if it is_plain_name and no secret, else a new one of 16
/// hexadecimal digits. `is_secret` may be null.
std::string checked_request_id(const std::string& given, const IsSecret& is_secret);

}  // namespace sightline

// Tests: tests/unit/server/http_server_test.cpp
