#include "server/http/chunk_decoder.h"

#include <algorithm>
#include <cstring>

#include "server/http/ascii.h"

namespace sightline {
namespace {

constexpr unsigned kMostDigits = 15;  // below 2^60
/// Of all extensions and trailers of one body: they say nothing here.
constexpr std::size_t kMostOverhead = 8192;

bool is_text(char c) { return c == '\t' || (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f); }

}  // namespace

ChunkDecoder::State ChunkDecoder::take_size(char c) {
  const int digit = hex_value(c);
  if (digit >= 0) {
    if (++digits_ > kMostDigits) return State::kBroken;
    left_ = left_ * 16 + static_cast<unsigned>(digit);
    return State::kSize;
  }
  if (digits_ == 0) return State::kBroken;
  if (c == ';') return State::kExtension;
  return c == '\r' ? State::kSizeEnd : State::kBroken;
}

ChunkDecoder::State ChunkDecoder::take_trailer(char c) {
  if (c == '\r') return State::kTrailerLf;
  ++line_;
  return is_text(c) && ++overhead_ <= kMostOverhead ? State::kTrailer : State::kBroken;
}

ChunkDecoder::State ChunkDecoder::step(char c) {
  switch (state_) {
    case State::kSize:
      return take_size(c);
    case State::kExtension:
      if (c == '\r') return State::kSizeEnd;
      return is_text(c) && ++overhead_ <= kMostOverhead ? State::kExtension : State::kBroken;
    case State::kSizeEnd:
      digits_ = 0;
      line_ = 0;
      if (c != '\n') return State::kBroken;
      return left_ > 0 ? State::kPayload : State::kTrailer;
    case State::kPayloadCr:
      return c == '\r' ? State::kPayloadLf : State::kBroken;
    case State::kPayloadLf:
      return c == '\n' ? State::kSize : State::kBroken;
    case State::kTrailer:
      return take_trailer(c);
    case State::kTrailerLf: {
      if (c != '\n') return State::kBroken;
      const bool was_empty = line_ == 0;
      line_ = 0;
      return was_empty ? State::kOver : State::kTrailer;
    }
    case State::kPayload:
    case State::kOver:
    case State::kBroken:
      break;
  }
  return State::kBroken;
}

std::size_t ChunkDecoder::decode(std::string_view& coded, char* payload) {
  std::size_t written = 0;
  while (!coded.empty() && !is_over() && !is_broken()) {
    if (state_ != State::kPayload) {
      state_ = step(coded.front());
      coded.remove_prefix(1);
      continue;
    }
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(left_, coded.size()));
    std::memmove(payload + written, coded.data(), count);
    written += count;
    left_ -= count;
    coded.remove_prefix(count);
    if (left_ == 0) state_ = State::kPayloadCr;
  }
  return written;
}

}  // namespace sightline
