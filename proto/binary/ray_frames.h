#pragma once
/// A stream of binary requests: docs/reference/binary.md, "Streams".

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "proto/binary/ray_binary.h"

namespace sightline {

inline constexpr std::string_view kStreamMagic = "SLS1";
/// The magic and four zeros.
inline constexpr std::size_t kStreamHeaderBytes = 8;
/// The length of a frame, before it.
inline constexpr std::size_t kFrameLengthBytes = 8;

/// Whether a body that begins so is a stream, with four bytes at least.
inline bool is_stream(std::string_view begin) { return begin.starts_with(kStreamMagic); }

/// Errors: BINARY_MALFORMED.
Status check_stream_header(std::string_view header);
/// Errors: 413 FRAME_TOO_LARGE.
Result<std::uint64_t> read_frame_length(std::string_view bytes);
/// Length and text, ready to be sent.
std::string framed(std::string_view text);

/// Decodes frame after frame, each a request of its own; those without options have the first
/// one's.
class RayFrames {
 public:
  explicit RayFrames(const RayJsonRules& rules) : rules_(rules) {}
  /// Errors: those of decode_rays_binary.
  Result<RayQuery> decode(std::string_view frame);

 private:
  RayJsonRules rules_;
  std::optional<RayQuery> options_;
};

}  // namespace sightline

// Tests: tests/unit/proto/ray_lines_test.cpp
