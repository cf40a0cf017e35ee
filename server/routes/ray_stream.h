#pragma once
/// Rays that are answered while they are still being sent: lines of JSON, or frames of bytes.

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

/// A stream of rays. Whatever has arrived is answered as soon as it is complete: every whole line
/// so far, or one frame. Memory does not grow with the length of the stream, and answers are in
/// order. An error in the first batch is answered as for any request, a later one as the last line
/// or frame. The client has to read while it sends.
class RayStream {
 public:
  enum class Form { kLines, kFrames };

  /// `begin`: of the body, what was read already. The exchange is left when the stream begins.
  RayStream(Exchange& exchange, const Service& service, const Journal& journal,
            std::shared_ptr<const Scene> scene, RayQuestionKind kind, Form form, std::string begin);

  RayStream(const RayStream&) = delete;
  RayStream& operator=(const RayStream&) = delete;
  /// The end of the answer, however it came.
  ~RayStream();

  /// Answers the exchange with a stream, or with what is wrong. Precondition:
  /// BodyReader::may_wait.
  static void reply(Exchange& exchange, const Service& service, const Journal& journal,
                    std::shared_ptr<const Scene> scene, RayQuestionKind kind, Form form,
                    std::string begin);

 private:
  /// The next part of the answer: empty at the end.
  Result<std::string> next();
  Result<std::string> next_lines();
  Result<std::string> next_frame();
  Result<std::string> answer(Result<RayQuery> query);
  void forget_filter();
  /// Receives until the buffer has that many bytes or the body has ended; with `wait` false also
  /// until nothing more has arrived.
  Status receive(std::size_t bytes, bool wait);
  /// fill() where the buffer has fewer.
  Status fill(std::size_t bytes);
  /// A line or frame that says what is wrong.
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
  std::size_t counted_ = 0;  ///< bytes of the buffer that are counted as a body
  bool ended_ = false;       ///< the body has
  bool failed_ = false;      ///< nothing is said any more
  bool complete_ = false;    ///< everything was answered
  StreamNote note_;
  bool begun_ = false;  ///< the answer is a stream, not a refusal
};

}  // namespace sightline
