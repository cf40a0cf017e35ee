// Rays, points and streams of frames as bytes: an error, or numbers that have passed the border and
// that are written and read again as the same.
// Run:  scripts/stress.sh fuzz --target ray_binary_fuzz

#include <cmath>
#include <string>
#include <string_view>

#include "proto/binary/point_binary.h"
#include "proto/binary/ray_binary.h"
#include "proto/binary/ray_frames.h"
#include "proto/json/ray_columns.h"
#include "tests/fuzz/body_check.h"

using namespace sightline;

namespace {

using fuzz::require;

/// Not a constant: it holds functions too.
RayJsonRules rules() { return {.max_rays = 64}; }

void check(const Result<RayQuery>& query) {
  if (!query) return fuzz::check_error(query.error());
  RayFault fault;
  require(check_rays(query->rays, fault), "rays have passed the border");
  require(query->rays.size() <= rules().max_rays, "limits hold");
  require(query->layout == AnswerLayout::kBinary, "bytes are answered by bytes");
  require(query->marks_invalid || query->invalid.number.empty(), "bad rays are refused or marked");
  const auto again = decode_rays_binary(encode_rays_binary(query->rays), rules());
  require(again.ok(), "what is written can be read");
  fuzz::check_same_rays(query->rays, again->rays);
}

void check_points(std::string_view body) {
  const auto query = decode_points_binary(body, {.max_points = 64, .has_fields = true});
  if (!query) return fuzz::check_error(query.error());
  require(query->points.size() <= 64, "limits hold");
  for (const Vec3d& p : query->points) {
    require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z), "points are finite");
  }
}

void check_stream(std::string_view body) {
  if (body.size() < kStreamHeaderBytes || !check_stream_header(body.substr(0, kStreamHeaderBytes)))
    return;
  body.remove_prefix(kStreamHeaderBytes);
  RayFrames frames(rules());
  while (body.size() >= kFrameLengthBytes) {
    const auto length = read_frame_length(body);
    if (!length) return fuzz::check_error(length.error());
    body.remove_prefix(kFrameLengthBytes);
    if (body.size() < *length) return;
    const std::string_view frame = body.substr(0, static_cast<std::size_t>(*length));
    require(framed(frame).size() == kFrameLengthBytes + frame.size(), "a frame has its length");
    check(frames.decode(frame));
    body.remove_prefix(frame.size());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // Not a part of something larger: a read past the end is seen.
  const std::string body(reinterpret_cast<const char*>(data), size);
  check_stream(body);
  check_points(body);
  check(decode_rays_binary(body, rules()));
  return 0;
}
