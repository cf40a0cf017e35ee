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

/// What a handler gets.
struct Exchange {
  const RequestHead& head;
  HttpResponse& response;
  BodyReader* body;          ///< null if there can be no body
  const CancelFlag* caller;  ///< set when the client no longer waits for the answer; may be null
  RequestMemory* memory;     ///< null if memory is not counted
  std::string request_id;
  std::string scene_id = {};  ///< the {id} of the path, percent-decoded, not validated
  std::string node_id = {};   ///< the {node} of the path, percent-decoded, not validated
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
  /// A refusal for lack of memory may still be put off.
  bool may_repeat = false;
  /// The answer is a stream, which counts its memory itself.
  bool streams = false;
  /// True if the client accepts exactly this media type and no other.
  bool wants(std::string_view media_type) const { return head.accept == media_type; }

  /// Reserves memory for this answer; to be called before much memory is allocated. Errors: those
  /// of RequestMemory::reserve.
  Status reserve(std::uint64_t bytes) const;

  /// Answers. media_type must be a literal.
  void reply(int status, std::string content, std::string_view media_type);
  void reply_json(int status, std::string content) {
    reply(status, std::move(content), "application/json");
  }
  void reply_empty(int status);
  /// Answers with a stream. Calls next(send) repeatedly, on a thread for streams where it may wait,
  /// until it returns false. send(text) returns false if the client is gone. Precondition:
  /// BodyReader::may_wait.
  using Send = HttpResponse::Send;
  void reply_stream(std::string_view media_type, std::function<bool(const Send& send)> next);
  /// Answers with an error; for kBusy also with the time after which to try again.
  void reply_error(const Error& error);
  void reply_problem(int status, std::string_view code, std::string detail);
  void reply_problem(Problem problem);
};

/// The client's X-Request-Id if it is_plain_name and no secret, else a new one of 16 hexadecimal
/// digits.
std::string checked_request_id(const std::string& given, const IsSecret& is_secret);

}  // namespace sightline
