#pragma once
/// Decodes streams of binary requests: docs/reference/binary.md, "Streams".

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "proto/binary/ray_binary.h"

namespace sightline {

/// The first bytes of a stream.
inline constexpr std::string_view kStreamMagic = "SLS1";
/// Size of the header of a stream: the magic and four zeros.
inline constexpr std::size_t kStreamHeaderBytes = 8;
/// Size of the length that precedes each frame.
inline constexpr std::size_t kFrameLengthBytes = 8;

/// True if a body that begins with `begin`, of at least four bytes, is a stream.
inline bool is_stream(std::string_view begin) { return begin.starts_with(kStreamMagic); }

/// Checks the header of a stream, kStreamHeaderBytes bytes. Errors: BINARY_MALFORMED.
Status check_stream_header(std::string_view header);
/// Reads the length of a frame in bytes. Precondition: `bytes` has at least kFrameLengthBytes
/// bytes. Errors: 413 FRAME_TOO_LARGE (more than 4 MiB).
Result<std::uint64_t> read_frame_length(std::string_view bytes);
/// Returns the text after its length, 8 bytes little-endian.
std::string framed(std::string_view text);

/// Decodes the frames of one stream in order; each is a request of decode_rays_binary. A frame
/// without options has the options of the first frame. Not thread-safe.
class RayFrames {
 public:
  explicit RayFrames(const RayJsonRules& rules) : rules_(rules) {}
  /// Decodes a frame, without its length. Errors: those of decode_rays_binary.
  Result<RayQuery> decode(std::string_view frame);

 private:
  RayJsonRules rules_;
  std::optional<RayQuery> options_;
};

}  // namespace sightline

// Tests: tests/unit/proto/ray_lines_test.cpp
