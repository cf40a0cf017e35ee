#include "proto/binary/ray_frames.h"

#include <cstring>

namespace sightline {
namespace {

/// What one frame may take of a server's memory, with its answer some times as much.
constexpr std::uint64_t kLargestFrame = 4 << 20;

}  // namespace

Status check_stream_header(std::string_view header) {
  constexpr std::string_view kWanted("SLS1\0\0\0\0", kStreamHeaderBytes);
  if (header == kWanted) return success();
  return Error{ErrorKind::kMalformed, "BINARY_MALFORMED",
               "a stream begins with SLS1 and four bytes of zero", ""};
}

Result<std::uint64_t> read_frame_length(std::string_view bytes) {
  std::uint64_t length = 0;
  std::memcpy(&length, bytes.data(), sizeof length);
  if (length <= kLargestFrame) return length;
  return Error{ErrorKind::kTooLarge, "FRAME_TOO_LARGE",
               "a frame may have " + std::to_string(kLargestFrame) + " bytes, this has " +
                   std::to_string(length),
               ""};
}

std::string framed(std::string_view text) {
  const std::uint64_t length = text.size();
  std::string frame(sizeof length, '\0');
  std::memcpy(frame.data(), &length, sizeof length);
  return frame.append(text);
}

Result<RayQuery> RayFrames::decode(std::string_view frame) {
  auto query = decode_rays_binary(frame, rules_, options_ ? &*options_ : nullptr);
  if (!query || options_) return query;
  options_ = *query;
  options_->rays = {};
  options_->invalid = {};
  return query;
}

}  // namespace sightline
