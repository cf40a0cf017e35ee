#pragma once
/// AlphaTexture: the alpha of a material's base colour texture, for rays with an alpha cutoff.

#include <cstdint>

#include "core/base/result.h"
#include "core/base/watch.h"

namespace sightline {

/// The alpha of an image in a file. Thread-safe. No decision depends on it but that of the cutoff.
class AlphaTexture {
 public:
  virtual ~AlphaTexture() = default;
  /// Decodes the image if that has not been done; its alpha stays in memory, a byte for each texel.
  /// Calls `reserve` with the bytes first. Must have succeeded before at(). Errors:
  /// ALPHA_UNREADABLE for an image or a texture that cannot be used; those of `reserve`. Throws
  /// std::bad_alloc.
  virtual Status prepare(const ReserveBytes& reserve) const = 0;
  /// The alpha, 0 to 255, of the nearest texel at texture coordinates that are finite:
  /// 1. offset + scale * (u, v), each in float64 (KHR_texture_transform)
  /// 2. wrapped to [0, 1]: REPEAT x - floor(x); CLAMP_TO_EDGE to the nearer end; MIRRORED_REPEAT
  ///    m = x - 2 floor(x / 2), then m or 2 - m
  /// 3. column min(floor(u * width), width - 1), row min(floor(v * height), height - 1), row 0 on
  ///    top
  /// An image without alpha, also any JPEG, has 255.
  virtual std::uint8_t at(double u, double v) const = 0;
};

}  // namespace sightline

// Tests: tests/integration/alpha_cutoff_test.py
