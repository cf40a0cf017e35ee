#include "server/routes/ray_stream.h"

#include <algorithm>
#include <new>
#include <utility>

#include "core/run/resolved_filter.h"
#include "core/run/unmatched_names.h"
#include "proto/binary/hit_binary.h"
#include "proto/json/hit_lines.h"
#include "server/http/body_reader.h"
#include "server/http/http_status.h"
#include "server/http/request_body.h"

namespace sightline {
namespace {

/// The most bytes of lines that are answered in one batch, when they come faster than they are
/// answered.
constexpr std::size_t kBatchBytes = 256 << 10;
constexpr std::size_t kLongestRayLine = 64 << 10;

Error too_long() {
  return {ErrorKind::kTooLarge, "LINE_TOO_LONG",
          "a line may have " + std::to_string(kLongestRayLine) + " bytes", ""};
}

/// A line that is too long is refused, in whatever pieces it came.
bool has_long_line(std::string_view lines) {
  while (lines.size() > kLongestRayLine) {
    const std::size_t end = lines.rfind('\n', kLongestRayLine);
    if (end == std::string_view::npos) return true;
    lines.remove_prefix(end + 1);
  }
  return false;
}
/// Rays of one frame: what bounds the memory of a stream.
constexpr std::size_t kFrameRays = 64 << 10;

RayJsonRules line_rules(RayQuestionKind kind, const ServiceLimits& limits) {
  RayJsonRules rules = rules_of(kind, limits);
  rules.has_explain = false;
  return rules;
}

RayJsonRules frame_rules(RayQuestionKind kind, const ServiceLimits& limits) {
  RayJsonRules rules = rules_of(kind, limits);
  rules.max_rays = std::min(rules.max_rays, kFrameRays);
  return rules;
}

}  // namespace

RayStream::RayStream(Exchange& exchange, const Service& service, const Journal& journal,
                     std::shared_ptr<const Scene> scene, RayQuestionKind kind, Form form,
                     std::string begin)
    : service_(service),
      journal_(journal),
      body_(exchange.body),
      caller_(exchange.caller),
      revoked_(exchange.head.revoked),
      memory_(exchange.memory),
      request_id_(exchange.request_id),
      scene_(std::move(scene)),
      kind_(kind),
      form_(form),
      lines_(line_rules(kind, service.limits)),
      frames_(frame_rules(kind, service.limits)),
      buffer_(std::move(begin)),
      note_(exchange) {}

RayStream::~RayStream() {
  if (!begun_) return;
  try {
    if (note_.code.empty() && !complete_) {
      note_.code = caller_ != nullptr && caller_->cancelled() ? "CLIENT_GONE" : "ANSWER_NOT_TAKEN";
    }
    note_stream_end(journal_, note_);
  } catch (const std::bad_alloc&) {
    // The line in the log is missed; a destructor that throws would end the server.
  }
}

Deadline RayStream::deadline(std::optional<std::uint64_t> timeout_ms) const {
  Deadline deadline = service_.deadline(timeout_ms);
  deadline.caller = caller_;
  return deadline;
}

Status RayStream::receive(std::size_t bytes, bool wait) {
  Status held = success();
  const bool good = body_->read(
      [&](std::span<const char> piece) {
        buffer_.append(piece.data(), piece.size());
        const std::size_t holds = buffer_.capacity();
        if (memory_ != nullptr && holds > counted_) {
          held = memory_->reserve(holds - counted_);
          if (held) counted_ = holds;
        }
        return held && buffer_.size() < bytes;
      },
      wait);
  if (!held) return held;
  if (!good && body_->fault() != BodyReader::Fault::kNoFault) return body_fault(body_);
  ended_ = good && body_->is_over();
  return success();
}

Status RayStream::fill(std::size_t bytes) {
  if (buffer_.size() >= bytes || ended_) return success();
  return receive(bytes, true);
}

Result<std::string> RayStream::next_lines() {
  // One line at least, and then what has come meanwhile.
  std::size_t looked = 0;
  while (!ended_ && buffer_.find('\n', looked) == std::string::npos) {
    if (buffer_.size() > kLongestRayLine) return too_long();
    looked = buffer_.size();
    if (Status status = fill(buffer_.size() + 1); !status) return std::move(status).error();
  }
  if (!ended_ && buffer_.size() < kBatchBytes) {
    if (Status status = receive(kBatchBytes, false); !status) return std::move(status).error();
  }
  const std::size_t end = ended_ ? buffer_.size() : buffer_.rfind('\n') + 1;
  std::string batch = buffer_.substr(0, end);
  buffer_.erase(0, end);
  if (batch.empty()) return std::string();
  if (has_long_line(batch)) return too_long();
  if (Status status = reserve_decoding(memory_, batch); !status) return std::move(status).error();
  return answer(lines_.decode(batch));
}

Result<std::string> RayStream::next_frame() {
  if (Status status = fill(kFrameLengthBytes); !status) return std::move(status).error();
  if (buffer_.empty()) return std::string();
  if (buffer_.size() < kFrameLengthBytes) return body_fault(nullptr);
  const auto length = read_frame_length(buffer_);
  if (!length) return length.error();
  const auto size = static_cast<std::size_t>(*length);
  if (Status status = fill(kFrameLengthBytes + size); !status) return std::move(status).error();
  if (buffer_.size() < kFrameLengthBytes + size) return body_fault(nullptr);
  if (Status status = reserve_decoding(memory_, buffer_); !status) return std::move(status).error();
  auto answered = answer(frames_.decode(std::string_view(buffer_).substr(kFrameLengthBytes, size)));
  buffer_.erase(0, kFrameLengthBytes + size);
  if (!answered) return answered;
  return framed(*answered);
}

void RayStream::forget_filter() {
  resolved_.reset();
  knows_filter_ = false;
}

Result<std::string> RayStream::answer(Result<RayQuery> query) {
  if (!query) return std::move(query).error();
  if (revoked_ && revoked_->cancelled()) {
    return Error{ErrorKind::kCancelled, "CANCELLED", "the key of this stream was taken out", ""};
  }
  if (form_ == Form::kFrames) {
    if (Status status = check_binary_fields(query->fields, query->named_fields); !status)
      return status.error();
  }
  Deadline deadline = this->deadline(query->timeout_ms);
  deadline.threads = query->threads;
  if (Status known =
          tell_unknown_fields(scene_->description(), query->named_fields, deadline, nullptr);
      !known) {
    return std::move(known).error();
  }
  const bool has_masks = !query->rays.mask.empty();
  if (!knows_filter_ || has_masks || form_ == Form::kFrames) {
    forget_filter();
    auto resolved =
        resolve_for_rays(*scene_, query->filter, query->rays.mask, deadline, reserve_from(memory_));
    if (!resolved) return std::move(resolved).error();
    resolved_ = std::move(*resolved);
    knows_filter_ = !has_masks;
  }
  WorkTimer timer;
  const RayOptions options{resolved_ ? &*resolved_ : nullptr, &timer.report.work, true,
                           reserve_from(memory_), query->alpha_cutoff};
  auto text = answer_rays(kind_, service_, *scene_, *query, options, deadline, timer);
  // Nor is it resolved in memory where the next part has to work it out anew.
  if (!knows_filter_ || form_ == Form::kFrames) forget_filter();
  journal_.metrics.count_part(query->rays.size(), timer.report.work);
  if (text) note_.rays += query->rays.size();
  return text;
}

Result<std::string> RayStream::next() try {
  body_->restart_pace();
  for (;;) {
    auto part = form_ == Form::kLines ? next_lines() : next_frame();
    // Lines may all be empty ones.
    if (memory_ != nullptr) {
      const std::uint64_t filter = resolved_ ? resolved_filter_bytes(*scene_) : 0;
      memory_->keep(counted_ + filter + (part ? part->size() : 0));
    }
    if (!part || !part->empty() || (ended_ && buffer_.empty())) return part;
  }
} catch (const std::bad_alloc&) {
  return Error{ErrorKind::kOutOfSpace, "MEMORY_FULL", "there is no memory left for this request",
               ""};
}

std::string RayStream::last_words(const Error& error) const {
  const int status = http_status(error.kind);
  Problem problem = make_problem(error, status, std::string(status_title(status)));
  problem.request_id = request_id_;
  const std::string text = encode_problem(problem);  // ends with a line
  return form_ == Form::kLines ? text : framed(text);
}

void RayStream::reply(Exchange& exchange, const Service& service, const Journal& journal,
                      std::shared_ptr<const Scene> scene, RayQuestionKind kind, Form form,
                      std::string begin) {
  const auto stream = std::make_shared<RayStream>(exchange, service, journal, std::move(scene),
                                                  kind, form, std::move(begin));
  std::string head;
  if (form == Form::kFrames) {
    // Admitted by its first bytes: the rest of the header must be as it should.
    Status status = stream->fill(kStreamHeaderBytes);
    if (status) {
      head = stream->buffer_.substr(0, kStreamHeaderBytes);
      status = check_stream_header(head);
    }
    if (!status) return exchange.reply_error(status.error());
    stream->buffer_.erase(0, kStreamHeaderBytes);
  }
  auto first = stream->next();
  if (!first && exchange.body->fault() != BodyReader::Fault::kNoFault) {
    return reply_body_fault(exchange);
  }
  if (!first) return exchange.reply_error(first.error());
  const auto say = [stream, part = head + *first](const Exchange::Send& send) mutable {
    if (!part.empty() && !send(part)) return false;
    stream->note_.bytes += part.size();
    part.clear();
    if (stream->failed_) return false;
    auto next = stream->next();
    stream->failed_ = !next;
    if (!next) stream->note_.code = next.error().code;
    part = next ? std::move(*next) : stream->last_words(next.error());
    stream->complete_ = part.empty();
    return !part.empty();
  };
  stream->begun_ = true;
  exchange.reply_stream(form == Form::kLines ? kLinesMediaType : kBinaryMediaType, say);
}

}  // namespace sightline
