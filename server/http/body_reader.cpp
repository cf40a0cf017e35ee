#include "server/http/body_reader.h"

#include <algorithm>
#include <string>

#include "server/http/connection_stream.h"

namespace sightline {
namespace {

/// A body that a route did not read is read over when it is no longer than this, so that the
/// connection lives on; else the connection ends.
constexpr std::uint64_t kSkippedBody = 64 << 10;
constexpr std::size_t kPiece = 32 << 10;

}  // namespace

BodyReader::BodyReader(Connection& connection, ConnectionStream& stream, const PaceLimits& pace,
                       std::uint64_t busy_rate, RequestMemory& memory)
    : connection_(connection),
      stream_(stream),
      since_(connection.head.has_body() ? Pace::Clock::now() : connection.asked_at),
      pace_(pace, since_),
      hurry_({busy_rate, pace.window, pace.longest}, since_),
      left_(connection.head.length.value_or(0)),
      owes_continue_(connection.head.expects_continue && connection.head.has_body()),
      memory_(memory) {}

bool BodyReader::is_over() const {
  return connection_.head.chunked ? chunks_.is_over() : left_ == 0;
}

bool BodyReader::is_skippable() const {
  // Where a client was never told to go on it may send its body or not.
  return !connection_.head.chunked && fault_ == Fault::kNoFault && left_ <= kSkippedBody &&
         (!owes_continue_ || left_ == 0);
}

void BodyReader::decode_as(Coding coding) {
  if (coding != Coding::kIdentity && !decoder_) decoder_ = std::make_unique<ContentDecoder>(coding);
}

void BodyReader::restart_pace() {
  since_ = Pace::Clock::now();
  pace_.restart(since_);
  hurry_.restart(since_);
}

void BodyReader::received(std::size_t bytes) {
  has_received_ = true;
  since_ = Pace::Clock::now();
  pace_.moved(bytes, since_);
  hurry_.moved(bytes, since_);
}

bool BodyReader::wait_for_client() {
  for (;;) {
    const Pace::Clock::time_point now = Pace::Clock::now();
    if (now >= pace_.due()) {
      fault_ = Fault::kSlow;
    } else if (now >= hurry_.due() && memory_.body_keeps_others_waiting()) {
      fault_ = Fault::kMemory;
    }
    if (fault_ != Fault::kNoFault) return false;
    const auto due = std::min(pace_.due(), now + kSlowClientLook);
    if (wait_until_readable(connection_.socket, due)) return true;
  }
}

bool BodyReader::get(const std::function<Received()>& receive, bool wait) {
  if (owes_continue_) {
    owes_continue_ = false;
    constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
    stream_.write(kContinue.data(), kContinue.size());
    if (!stream_.flush()) fault_ = Fault::kEnded;
  }
  // It is not the client's time that went by while this waited for memory, or decoded.
  const Pace::Clock::time_point now = Pace::Clock::now();
  pace_.pause(now - since_);
  hurry_.pause(now - since_);
  since_ = now;
  while (fault_ == Fault::kNoFault) {
    switch (receive()) {
      case Received::kSome:
      case Received::kAll:
        return true;
      case Received::kEnd:
        fault_ = Fault::kEnded;
        break;
      case Received::kNothing:
        if (!wait) return false;
        wait_for_client();
        break;
    }
  }
  return false;
}

bool BodyReader::get_input(bool wait) {
  if (!connection_.pending_input().empty()) return true;
  const auto wanted = static_cast<std::size_t>(
      connection_.head.chunked ? kPiece : std::min<std::uint64_t>(left_, kPiece));
  if (!get([&] { return receive_some(connection_, wanted); }, wait)) return false;
  received(connection_.pending_input().size());
  return true;
}

bool BodyReader::read_all(std::string& text, const std::function<bool(std::size_t)>& admit) {
  const auto append = [&](std::span<const char> piece) {
    if (!admit(piece.size())) return false;
    text.append(piece.data(), piece.size());
    return true;
  };
  if (decoder_ || connection_.head.chunked) return read(append);
  if (!connection_.pending_input().empty() && !pass_on(append)) return false;
  // What is received goes behind `end`; bytes there are made ready once, however small the pieces.
  std::size_t end = text.size();
  bool good = true;
  while (good && left_ > 0) {
    // As much again as has come: a client that sends little holds little.
    constexpr std::size_t kAhead = 64 << 10, kMostAhead = 1 << 20;
    if (text.size() == end) {
      const auto ahead = static_cast<std::size_t>(
          std::min<std::uint64_t>(left_, std::clamp(end, kAhead, kMostAhead)));
      good = admit(ahead);
      if (good) text.resize(end + ahead);
    }
    std::size_t count = 0;
    good = good &&
           get([&] { return receive_at(connection_, text.data() + end, text.size() - end, count); },
               true);
    if (!good) break;
    received(count);
    end += count;
    left_ -= count;
  }
  text.resize(end);
  return good;
}

bool BodyReader::pass_on(const std::function<bool(std::span<const char>)>& sink) {
  std::string_view pending = connection_.pending_input();
  // It has begun without being told to [RFC9110] 10.1.1; said later it would stand in the answer.
  if (!pending.empty()) owes_continue_ = false;
  if (!connection_.head.chunked) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(left_, pending.size()));
    const bool wanted = sink({pending.data(), count});
    left_ -= count;
    connection_.take(count);
    return wanted;
  }
  // In its own place: a payload is never longer than its chunks.
  char* payload = connection_.input.data() + connection_.taken;
  const std::size_t before = pending.size();
  const std::size_t count = chunks_.decode(pending, payload);
  const bool wanted = count == 0 || sink({payload, count});
  connection_.take(before - pending.size());
  if (chunks_.is_broken()) fault_ = Fault::kEnded;
  return wanted && fault_ == Fault::kNoFault;
}

bool BodyReader::hand_on_decoded(const std::function<bool(std::span<const char>)>& sink) {
  std::string_view input = held_;
  bool wanted = true;
  while (wanted) {
    const std::span<const char> piece = decoder_->decode(input);
    const std::size_t bytes = decoder_->bytes();
    if (bytes > decoder_bytes_) {
      if (!memory_.reserve_body(bytes - decoder_bytes_)) {
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
    if (!get_input(wait)) return fault_ == Fault::kNoFault;
    if (!pass_on(decoder_ ? hold : sink)) return false;
  }
}

}  // namespace sightline
