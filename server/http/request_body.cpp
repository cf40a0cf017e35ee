#include "server/http/request_body.h"

#include <algorithm>
#include <optional>

#include "server/http/body_reader.h"
#include "server/http/request_memory.h"

namespace sightline {
namespace {

/// What a parser takes, and what comes out of it: of a ray of 40 bytes 64.
constexpr std::uint64_t kWorkPerByte = 8;
constexpr std::uint64_t kShortBody = 64 << 10;

void reply_too_large(Exchange& exchange, std::uint64_t limit) {
  exchange.reply_problem(413, "BODY_TOO_LARGE",
                         "the body may have " + std::to_string(limit) + " bytes");
}

}  // namespace

std::optional<std::uint64_t> body_length(const Exchange& exchange) { return exchange.head.length; }

bool admit_stream(Exchange& exchange) {
  const auto coding = exchange.head.coding;
  if (!coding) {
    exchange.response.set_header("Accept-Encoding", "gzip, zstd");
    exchange.reply_problem(415, "ENCODING_UNSUPPORTED",
                           "send the body in gzip, in zstd, or without Content-Encoding");
    return false;
  }
  if (!exchange.head.chunked && !body_length(exchange)) {
    exchange.reply_problem(411, "LENGTH_REQUIRED", "send Content-Length, or a chunked body");
    return false;
  }
  if (exchange.body != nullptr) exchange.body->decode_as(*coding);
  return true;
}

bool admit_body(Exchange& exchange, std::uint64_t limit) {
  if (!admit_stream(exchange)) return false;
  if (body_length(exchange).value_or(0) <= limit) return true;
  reply_too_large(exchange, limit);
  return false;
}

Error body_fault(const BodyReader* body) {
  const auto fault = body == nullptr ? BodyReader::Fault::kEnded : body->fault();
  if (fault == BodyReader::Fault::kSlow) {
    return {ErrorKind::kDeadline, "REQUEST_TIMEOUT", "the body of the request came too slowly", ""};
  }
  if (fault == BodyReader::Fault::kMemory) {
    return {ErrorKind::kBusy, "MEMORY_BUSY",
            "others wait for the memory that bodies use: send it again later", ""};
  }
  if (fault == BodyReader::Fault::kCoding) {
    return {ErrorKind::kMalformed, "ENCODING_BROKEN",
            "the body is not what its Content-Encoding says, or ends too early", ""};
  }
  if (fault == BodyReader::Fault::kDisk) {
    return {ErrorKind::kInternal, "SPOOL_UNREADABLE",
            "the temporary file that holds the body cannot be read", ""};
  }
  return {ErrorKind::kMalformed, "BODY_INCOMPLETE", "the body ended early or its framing is broken",
          ""};
}

void reply_body_fault(Exchange& exchange) {
  const Error error = body_fault(exchange.body);
  if (error.kind == ErrorKind::kBusy || error.kind == ErrorKind::kInternal) {
    return exchange.reply_error(error);
  }
  exchange.reply_problem(error.kind == ErrorKind::kDeadline ? 408 : 400, error.code, error.message);
}

namespace {

/// Whether bytes of a body are taken: fewer than the limit in total, and what `admit` says.
class BodyLimit {
 public:
  BodyLimit(Exchange& exchange, std::uint64_t limit, std::uint64_t size = 0)
      : exchange_(exchange), limit_(limit), size_(size) {}

  template <class Admit>
  bool take(std::size_t bytes, const Admit& admit) {
    size_ += bytes;
    too_large_ = size_ > limit_;
    if (too_large_) return false;
    Status status = admit();
    if (!status) refused_ = std::move(status).error();
    return !refused_;
  }
  /// Answers a body that did not come to its end.
  void reply() {
    if (too_large_) {
      reply_too_large(exchange_, limit_);
    } else if (refused_) {
      exchange_.reply_error(*refused_);
    } else {
      reply_body_fault(exchange_);
    }
  }

 private:
  Exchange& exchange_;
  const std::uint64_t limit_;
  std::uint64_t size_;
  bool too_large_ = false;
  std::optional<Error> refused_;
};

/// The memory of a body's text.
class BodyRoom {
 public:
  /// spare   bytes behind the body
  /// length  of the whole text, where it is known
  /// memory  null: it is not counted
  BodyRoom(std::string& text, std::size_t spare, std::optional<std::uint64_t> length,
           RequestMemory* memory)
      : text_(text), spare_(spare), length_(length.value_or(0)), memory_(memory) {}

  /// For so many bytes more.
  Status make_for(std::size_t bytes) {
    const std::size_t least = text_.size() + bytes + spare_;
    if (least <= room_) return success();
    constexpr std::size_t kFirst = 128 << 10;
    const std::size_t room = length_ > 0 ? std::max<std::size_t>(least, length_ + spare_)
                                         : std::max({least, kFirst, 2 * room_});
    if (Status status = reserve(memory_, room - room_); !status) return status;
    room_ = room;
    // To reserve more in the same text may double it instead.
    std::string larger;
    larger.reserve(room);
    larger.append(text_);
    text_.swap(larger);
    return success();
  }

 private:
  std::string& text_;
  const std::size_t spare_;
  const std::uint64_t length_;
  RequestMemory* const memory_;
  std::size_t room_ = 0;
};

}  // namespace

bool is_body_here(const Exchange& exchange, std::uint64_t limit) {
  // One byte beyond the limit is enough to refuse it.
  return exchange.body == nullptr || exchange.body->ask_for(limit + 1);
}

bool read_body_in_parts(Exchange& exchange, std::uint64_t limit, std::shared_ptr<void> state,
                        const std::function<Status(std::span<const char>)>& sink) {
  BodyReader* reader = exchange.body;
  BodyLimit body(exchange, limit, reader == nullptr ? 0 : reader->read_before());
  const auto receive = [&](std::span<const char> piece) {
    return body.take(piece.size(), [&] { return sink(piece); });
  };
  if (reader == nullptr || !reader->read(receive)) {
    body.reply();
    return false;
  }
  if (reader->is_over()) return true;
  reader->kept() = std::move(state);
  reader->ask_for_next_part();
  return false;
}

/// read_body for a body that was read before.
static bool copy_body(Exchange& exchange, std::size_t spare, std::string& text) {
  const std::string& whole = *exchange.whole_body;
  Status status = exchange.reserve(whole.size() + spare);
  if (status) {
    text.reserve(text.size() + whole.size() + spare);
    text += whole;
    status = reserve_decoding(exchange.memory, text);
  }
  if (!status) exchange.reply_error(status.error());
  return status.ok();
}

bool read_body(Exchange& exchange, std::uint64_t limit, std::size_t spare, std::string& text) {
  if (exchange.whole_body != nullptr) return copy_body(exchange, spare, text);
  if (!is_body_here(exchange, limit)) return false;
  std::optional<std::uint64_t> length;
  if (exchange.body != nullptr) length = exchange.body->unread_bytes();
  if (length) *length += text.size();
  // Short ones are few bytes for each worker.
  const bool is_short = length && *length <= kShortBody;
  BodyLimit body(exchange, limit);
  BodyRoom room(text, spare, length, is_short ? nullptr : exchange.memory);
  const auto admit = [&](std::size_t bytes) {
    return body.take(bytes, [&] { return room.make_for(bytes); });
  };
  if (!body.take(text.size(), success) || exchange.body == nullptr ||
      !exchange.body->read_all(text, admit) || !exchange.body->is_over()) {
    body.reply();
    return false;
  }
  Status status = reserve_decoding(exchange.memory, text);
  if (!status) exchange.reply_error(status.error());
  return status.ok();
}

Status reserve_decoding(RequestMemory* memory, std::string_view body) {
  return reserve(memory, body.size() * kWorkPerByte);
}

void forget_body(Exchange& exchange, std::string& text, std::uint64_t bytes) {
  std::string().swap(text);
  if (exchange.memory == nullptr) return;
  if (exchange.body != nullptr) exchange.body->end_decoding();
  exchange.memory->keep(bytes);
}

}  // namespace sightline
