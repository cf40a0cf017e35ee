#include "server/http/body_reader.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "server/http/response_writer.h"

namespace sightline {
namespace {

/// A body that a route did not read is read over when it is no longer than this, so that the
/// connection lives on; else the connection ends.
constexpr std::uint64_t kSkippedBody = 64 << 10;
constexpr std::size_t kPiece = 32 << 10;

}  // namespace

BodyReader::BodyReader(Connection& connection, ResponseWriter& writer, const PaceLimits& pace,
                       std::uint64_t busy_rate, RequestMemory& memory)
    : connection_(connection),
      writer_(writer),
      since_(connection.streams ? Pace::Clock::now() : connection.asked_at),
      pace_(pace, since_),
      busy_pace_({busy_rate, pace.window, pace.longest}, since_),
      gathered_(connection.is_gathered ? connection.head.length.value_or(0) : 0),
      memory_(memory) {
  if (connection.body) connection.body->rewind();
}

bool BodyReader::is_over() const {
  if (!connection_.head.has_body()) return true;
  if (connection_.body) return connection_.body->is_whole() && connection_.body->unread() == 0;
  return connection_.is_gathered && gathered_ == 0;
}

std::uint64_t BodyReader::unread() const {
  if (!connection_.head.has_body()) return 0;
  if (connection_.body) return connection_.body->is_whole() ? 0 : connection_.body->to_come();
  return connection_.is_gathered ? gathered_ : connection_.head.length.value_or(0);
}

bool BodyReader::is_skippable() const {
  if (fault_ != Fault::kNoFault) return false;
  if (!connection_.head.has_body()) return true;
  if (connection_.body && connection_.body->is_whole()) return true;
  // Where a client was never told to go on it may send its body or not.
  return !connection_.head.chunked && !connection_.owes_continue && unread() <= kSkippedBody;
}

void BodyReader::finish() { connection_.take(gathered_at_); }

std::optional<std::uint64_t> BodyReader::unread_bytes() const {
  if (decoder_) return {};
  if (connection_.body) return connection_.body->unread();
  return gathered_;
}

bool BodyReader::ask_for(std::uint64_t bytes) {
  if (is_put_off()) return false;
  if (is_over() || connection_.is_gathered || connection_.streams) return true;
  const ReceivedBody* body = connection_.body.get();
  if (body != nullptr && (body->is_whole() || body->is_broken() || body->size() >= bytes)) {
    return true;
  }
  connection_.body_wanted = bytes;
  connection_.put_off = Connection::PutOff::kForBody;
  return false;
}

void BodyReader::ask_for_next_part() {
  ReceivedBody* body = connection_.body.get();
  if (body != nullptr) body->begin_part();
  connection_.body_wanted = (body != nullptr ? body->size() : 0) + ReceivedBody::kPart;
  connection_.put_off = Connection::PutOff::kForBody;
}

bool BodyReader::may_wait() {
  if (connection_.streams) return true;
  if (!is_put_off()) connection_.put_off = Connection::PutOff::kToStream;
  return false;
}

bool BodyReader::may_cost(std::uint64_t cost) {
  // Some 50 ms of one processor.
  constexpr std::uint64_t kShort = 64 << 10;
  if (cost <= kShort || connection_.is_long || connection_.streams) return true;
  if (!is_put_off()) connection_.put_off = Connection::PutOff::kToLong;
  connection_.expect(cost);
  return false;
}

void BodyReader::decode_as(Coding coding) {
  if (coding != Coding::kIdentity && !decoder_) decoder_ = std::make_unique<ContentDecoder>(coding);
}

void BodyReader::restart_pace() {
  since_ = Pace::Clock::now();
  pace_.restart(since_);
  busy_pace_.restart(since_);
}

bool BodyReader::wait_for_client() {
  for (;;) {
    const Pace::Clock::time_point now = Pace::Clock::now();
    if (now >= pace_.due()) {
      fault_ = Fault::kSlow;
    } else if (now >= busy_pace_.due() && memory_.keeps_others_waiting()) {
      fault_ = Fault::kMemory;
    }
    if (fault_ != Fault::kNoFault) return false;
    const auto due = std::min(pace_.due(), now + kSlowClientLook);
    if (wait_until_readable(connection_.socket, due)) return true;
  }
}

bool BodyReader::receive(bool wait) {
  if (!connection_.body) {
    connection_.body =
        std::make_unique<ReceivedBody>(connection_.head, connection_.budget, connection_.spool);
  }
  ReceivedBody& body = *connection_.body;
  if (body.unread() == 0) body.begin_part();
  // It has begun without being told to [RFC9110] 10.1.1; said later it would stand in the answer.
  if (!connection_.pending_input().empty()) connection_.owes_continue = false;
  if (std::exchange(connection_.owes_continue, false)) {
    constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
    writer_.write(kContinue);
    if (!writer_.flush()) fault_ = Fault::kEnded;
  }
  // It is not the client's time that went by while this waited for memory, or decoded.
  const Pace::Clock::time_point now = Pace::Clock::now();
  pace_.pause(now - since_);
  busy_pace_.pause(now - since_);
  since_ = now;
  while (fault_ == Fault::kNoFault && body.unread() == 0 && !body.is_whole()) {
    if (!connection_.pending_input().empty()) {
      const std::size_t bytes = connection_.pending_input().size();
      if (!take_body(connection_, kPiece)) fault_ = Fault::kMemory;
      if (body.is_broken()) fault_ = Fault::kEnded;
      has_received_ = true;
      since_ = Pace::Clock::now();
      pace_.moved(bytes, since_);
      busy_pace_.moved(bytes, since_);
      continue;
    }
    const auto most = static_cast<std::size_t>(
        body.is_chunked() ? kPiece : std::min<std::uint64_t>(body.to_come(), kPiece));
    switch (receive_some(connection_, most)) {
      case Received::kSome:
      case Received::kAll:
        break;
      case Received::kEnd:
        fault_ = Fault::kEnded;
        break;
      case Received::kNothing:
        if (!wait) return false;
        wait_for_client();
        break;
    }
  }
  return fault_ == Fault::kNoFault;
}

bool BodyReader::has_unread() const {
  return connection_.body ? connection_.body->unread() > 0 : gathered_ > 0;
}

bool BodyReader::pass_on(const std::function<bool(std::span<const char>)>& sink) {
  if (connection_.body) {
    std::array<char, kPiece> piece;
    const std::size_t count = connection_.body->read(piece.data(), piece.size());
    if (connection_.body->has_failed()) fault_ = Fault::kDisk;
    return sink({piece.data(), count}) && fault_ == Fault::kNoFault;
  }
  // It stays there: a request may yet be put off.
  const std::string_view pending = connection_.pending_input().substr(gathered_at_);
  const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(gathered_, pending.size()));
  if (count == 0) fault_ = Fault::kEnded;
  const bool wanted = count > 0 && sink({pending.data(), count});
  gathered_ -= count;
  gathered_at_ += count;
  return wanted;
}

bool BodyReader::read_all(std::string& text, const std::function<bool(std::size_t)>& admit) {
  if (decoder_ || !connection_.body) {
    return read([&](std::span<const char> piece) {
      if (!admit(piece.size())) return false;
      text.append(piece.data(), piece.size());
      return true;
    });
  }
  ReceivedBody& body = *connection_.body;
  while (body.unread() > 0) {
    // Pages of the text are touched as they are filled.
    constexpr std::size_t kAhead = 1 << 20;
    const auto ahead = static_cast<std::size_t>(std::min<std::uint64_t>(body.unread(), kAhead));
    if (!admit(ahead)) return false;
    const std::size_t end = text.size();
    text.resize(end + ahead);
    body.read(text.data() + end, ahead);
    if (body.has_failed()) {
      fault_ = Fault::kDisk;
      return false;
    }
  }
  if (body.is_broken()) fault_ = Fault::kEnded;
  return fault_ == Fault::kNoFault;
}

bool BodyReader::hand_on_decoded(const std::function<bool(std::span<const char>)>& sink) {
  std::string_view input = held_;
  bool wanted = true;
  while (wanted) {
    const std::span<const char> piece = decoder_->decode(input);
    const std::size_t bytes = decoder_->bytes();
    if (bytes > decoder_bytes_) {
      if (!memory_.pin(bytes - decoder_bytes_)) {
        fault_ = Fault::kMemory;
        return false;
      }
      decoder_bytes_ = bytes;
    }
    if (piece.empty()) break;
    wanted = sink(piece);
  }
  held_.erase(0, held_.size() - input.size());
  if (decoder_->is_broken() || (is_over() && held_.empty() && wanted && !decoder_->is_whole())) {
    fault_ = Fault::kCoding;
  }
  return wanted && fault_ == Fault::kNoFault;
}

bool BodyReader::read(const std::function<bool(std::span<const char>)>& sink, bool wait) {
  const std::function<bool(std::span<const char>)> hold = [&](std::span<const char> piece) {
    held_.append(piece.data(), piece.size());
    return true;
  };
  for (;;) {
    if (decoder_ && !hand_on_decoded(sink)) return false;
    if (is_over()) return true;
    if (!has_unread()) {
      if (connection_.body && connection_.body->is_broken()) fault_ = Fault::kEnded;
      if (fault_ != Fault::kNoFault) return false;
      if (!connection_.streams) return true;
      if (!receive(wait)) return fault_ == Fault::kNoFault;
      continue;
    }
    if (!pass_on(decoder_ ? hold : sink)) return false;
  }
}

}  // namespace sightline
