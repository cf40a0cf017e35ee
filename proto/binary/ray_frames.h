#pragma once
/// Decodes streams of binary requests: docs/reference/binary.md, "Streams".

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "proto/binary/ray_binary.h"

namespace sightline {

inline constexpr std::string_view kStreamMagic = "SLS1";
/// Size of the header of a stream: the magic and four zeros.
inline constexpr std::size_t kStreamHeaderBytes = 8;
/// Size of the length that precedes each frame.
inline constexpr std::size_t kFrameLengthBytes = 8;

/// True if a body that begins with `begin`, of at least four bytes, is a stream.
inline bool is_stream(std::string_view begin) { return begin.starts_with(kStreamMagic); }

/// Checks the header of a stream. Errors: BINARY_MALFORMED.
Status check_stream_header(std::string_view header);
/// Reads the length of a frame. Errors: 413 FRAME_TOO_LARGE.
Result<std::uint64_t> read_frame_length(std::string_view bytes);
/// Returns the text with its length before it.
std::string framed(std::string_view text);

/// Decodes one frame after the other; each is a request. A frame without options has the options of
/// the first frame.
class RayFrames {
 public:
  explicit RayFrames(const RayJsonRules& rules) : rules_(rules) {}
  /// Decodes a frame. Errors: those of decode_rays_binary.
  Result<RayQuery> decode(std::string_view frame);

 private:
  RayJsonRules rules_;
  std::optional<RayQuery> options_;
};

}  // namespace sightline

// Tests: tests/unit/proto/ray_lines_test.cpp
