#pragma once
/// RayStream: answers rays while the client is still sending, as lines of JSON or as binary frames.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/run/engine.h"
#include "proto/binary/ray_frames.h"
#include "proto/json/ray_lines.h"
#include "server/http/exchange.h"
#include "server/operation/request_log.h"
#include "server/service/ray_answer.h"
#include "server/service/service.h"

namespace sightline {

class BodyReader;

/// A stream of rays. Whatever has arrived is answered as soon as it is complete: all whole lines,
/// or a frame. Memory does not grow with the length of the stream, and answers are in order. An
/// error in the first batch is answered as for any request; a later one is the last line or frame.
/// The client must read while it sends.
class RayStream {
 public:
  /// The form of request and answer: lines of JSON (ray_lines.h), or binary frames (ray_frames.h).
  enum class Form { kLines, kFrames };

  /// Use reply() instead, which also sends the answer. `service`, the objects of `journal`, and
  /// body, caller and memory of `exchange` must outlive the stream; `exchange` itself is not
  /// stored.
  /// begin  the part of the body that was read already
  RayStream(Exchange& exchange, const Service& service, const Journal& journal,
            std::shared_ptr<const Scene> scene, RayQuestionKind kind, Form form, std::string begin);

  RayStream(const RayStream&) = delete;
  RayStream& operator=(const RayStream&) = delete;
  /// Logs the end of the stream, if it had begun.
  ~RayStream();

  /// Answers the exchange with a stream, or with an error. Precondition: BodyReader::may_wait.
  static void reply(Exchange& exchange, const Service& service, const Journal& journal,
                    std::shared_ptr<const Scene> scene, RayQuestionKind kind, Form form,
                    std::string begin);

 private:
  /// The next part of the answer; empty at the end.
  Result<std::string> next();
  Result<std::string> next_lines();
  Result<std::string> next_frame();
  Result<std::string> answer(Result<RayQuery> query);
  void forget_filter();
  /// Receives until the buffer has `bytes` bytes, or the body has ended; if not `wait`, also stops
  /// when no more has arrived.
  Status receive(std::size_t bytes, bool wait);
  /// Calls receive() if the buffer has fewer than `bytes` bytes.
  Status fill(std::size_t bytes);
  /// The last line or frame, which states an error.
  std::string last_words(const Error& error) const;
  Deadline deadline(std::optional<std::uint64_t> timeout_ms) const;

  const Service& service_;
  const Journal journal_;
  BodyReader* const body_;
  const CancelFlag* const caller_;
  const std::shared_ptr<const CancelFlag> revoked_;
  RequestMemory* const memory_;
  const std::string request_id_;
  const std::shared_ptr<const Scene> scene_;
  const RayQuestionKind kind_;
  const Form form_;
  RayLines lines_;
  RayFrames frames_;
  std::optional<ResolvedFilter> resolved_;
  bool knows_filter_ = false;
  std::string buffer_;
  std::size_t counted_ = 0;  ///< bytes of the buffer that memory accounting includes
  bool ended_ = false;       ///< the body has ended
  bool failed_ = false;      ///< nothing more is sent
  bool complete_ = false;    ///< everything was answered
  StreamNote note_;
  bool begun_ = false;  ///< the answer is a stream rather than an error
};

}  // namespace sightline

// Tests: tests/integration/streams_test.py
