#pragma once
/// ChunkDecoder: decodes the chunked transfer coding [RFC9112] 7.1 strictly. It knows no sockets.

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace sightline {

/// A size is digits without sign or blank, and a line ends with CR LF. Extensions and trailers are
/// skipped, and their length is limited. Anything that another program could read differently is a
/// fault.
class ChunkDecoder {
 public:
  /// Removes bytes from the front of `coded` and writes the payload in them to `payload`, which has
  /// room for `coded.size()` bytes and may be the same memory. Stops at the end of the body.
  /// Returns the number of bytes written.
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
  std::uint64_t left_ = 0;    ///< bytes left in this chunk
  unsigned digits_ = 0;       ///< digits of its size so far
  std::size_t line_ = 0;      ///< bytes of the present extension or trailer line
  std::size_t overhead_ = 0;  ///< bytes of extensions and trailers
};

}  // namespace sightline
