#pragma once
/// ChunkDecoder: decodes the chunked transfer coding [RFC9112] 7.1 strictly. It knows no sockets.

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace sightline {

/// The decoder of one body, which decode() gets piece by piece. A size is 1 to 15 hexadecimal
/// digits without sign or space, and a line ends with CR LF. Extensions and trailers are skipped;
/// they have at most 8192 bytes in total. Anything that another program could read differently is a
/// fault.
class ChunkDecoder {
 public:
  /// Removes bytes from the front of `coded` and writes the payload in them to `payload`, which has
  /// room for `coded.size()` bytes and may be the memory of `coded`. Stops at the end of the body
  /// or at a fault, with the rest left in `coded`. Returns the number of bytes written.
  std::size_t decode(std::string_view& coded, char* payload);
  /// True after the last byte of the body, with its trailers.
  bool is_over() const { return state_ == State::kOver; }
  /// True after a fault; decode() then does nothing.
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
  std::uint64_t left_ = 0;    ///< bytes left in this chunk
  unsigned digits_ = 0;       ///< digits of its size so far
  std::size_t line_ = 0;      ///< bytes of the present extension or trailer line
  std::size_t overhead_ = 0;  ///< bytes of extensions and trailers
};

}  // namespace sightline
