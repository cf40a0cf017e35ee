#pragma once
/// Encodes hits as an image with a pixel for each ray.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/query/hit_batch.h"

namespace sightline {

/// The media types of the two formats.
inline constexpr std::string_view kPngMediaType = "image/png";
inline constexpr std::string_view kFloatMapMediaType = "image/x-portable-floatmap";

/// What an image shows, and its format.
///
/// PNG, 16 bits a sample, rows from the top:
///   depth   grey: t / unit, rounded (half to even), limited to 1 to 65535; 0 is a miss
///   node    grey: index of the node in the file plus 1; 0 is a miss
///   normal  red, green, blue: 65535 (n + 1) / 2, rounded; 0 0 0 is a miss
///   visits  grey: number of boxes of trees that the ray was tested with, at most 65535; also for
///   misses
///   node_colours, shaded  red, green, blue: 65535 times the colour, rounded; 0 0 0 is a miss
///
/// PFM, little-endian float32, rows from the bottom as the format demands:
///   depth   t rounded to the nearest float32; +inf is a miss
///   node    index of the node in the file; -1 is a miss
///   normal  x, y, z; 0 0 0 is a miss
///   visits  number of boxes
///   node_colours, shaded  red, green, blue from 0 to 1; 0 0 0 is a miss
///
/// node_colours has the colour of node_colour.h for each node. shaded has the base colour of the
/// material times 0.25 + 0.75 |cos a|, where a is the angle between ray and normal.
struct HitImage {
  enum class Of { kDepth, kNode, kNormal, kVisits, kNodeColours, kShaded };
  Of of = Of::kDepth;
  bool floats = false;                  ///< true: PFM; false: PNG
  double unit = 0.001;                  ///< t of one step of a PNG's depth; above 0
  std::uint64_t width = 0, height = 0;  ///< in pixels

  std::string_view media_type() const { return floats ? kFloatMapMediaType : kPngMediaType; }
};

/// Some rows of an image as columns, one element for each pixel in the order of for_each_pixel
/// (ray_generators.h). A column that the image does not need may be empty.
struct HitPixels {
  const HitBatch& hits;
  std::span<const double> depth;          ///< for kDepth
  std::span<const std::uint32_t> node;    ///< for kNode: index in the file
  std::span<const Vec3d> normal;          ///< for kNormal
  std::span<const std::uint32_t> visits;  ///< for kVisits, of misses too
  std::span<const Vec3d> colour = {};     ///< for kNodeColours and kShaded: parts from 0 to 1
};

/// Encodes an image from its rows: check(), construct, draw() until each row is set, finish().
/// Holds the whole image. Throws std::bad_alloc. Not thread-safe.
class HitImageEncoder {
 public:
  /// Errors: IMAGE_TOO_LARGE (more than a million pixels wide or high).
  static Status check(const HitImage& image);
  /// Upper bound of the bytes of memory of an encoder and of its result.
  static std::uint64_t bytes(const HitImage& image);

  /// Precondition: check(image) succeeds.
  explicit HitImageEncoder(const HitImage& image);
  /// Sets rows [begin, end), row 0 at the top. Errors: IMAGE_NODES_TOO_MANY (a node's index is
  /// above 65534, for PNG); the image is then incomplete.
  Status draw(std::uint64_t begin, std::uint64_t end, const HitPixels& pixels);
  /// Returns the file of the image. Called once. Precondition: all rows are set. Errors:
  /// IMAGE_FAILED.
  Result<std::string> finish();

 private:
  Status draw_samples(std::uint64_t begin, std::uint64_t end, const HitPixels& pixels);
  void draw_floats(std::uint64_t begin, std::uint64_t end, const HitPixels& pixels);

  HitImage image_;
  std::uint64_t width_ = 1;  ///< numbers in a pixel
  std::size_t head_ = 0;     ///< bytes before the numbers of a PFM
  std::string floats_;
  std::vector<std::uint16_t> samples_;
};

}  // namespace sightline

// Tests: tests/integration/images_test.py
