#pragma once
/// The chunked transfer coding [RFC9112] 7.1, decoded strictly. Knows no sockets.

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace sightline {

/// Digits without sign or blank, CR LF and nothing else, extensions and trailers read over and
/// bounded: what another program could read otherwise is a fault.
class ChunkDecoder {
 public:
  /// Takes bytes off the front of `coded` and writes the payload among them to `payload`, which has
  /// room for `coded.size()` and may be the same memory. Stops where the body ends. Returns how
  /// many bytes it wrote.
  std::size_t decode(std::string_view& coded, char* payload);
  bool is_over() const { return state_ == State::kOver; }
  bool is_broken() const { return state_ == State::kBroken; }

 private:
  enum class State {
    kSize,
    kExtension,
    kSizeEnd,
    kPayload,
    kPayloadCr,
    kPayloadLf,
    kTrailer,
    kTrailerLf,
    kOver,
    kBroken
  };
  State step(char c);
  State take_size(char c);
  State take_trailer(char c);

  State state_ = State::kSize;
  std::uint64_t left_ = 0;    ///< of the payload of this chunk
  unsigned digits_ = 0;       ///< of its size
  std::size_t line_ = 0;      ///< bytes of this extension, or of this line of the trailer
  std::size_t overhead_ = 0;  ///< bytes of extensions and trailers
};

}  // namespace sightline
