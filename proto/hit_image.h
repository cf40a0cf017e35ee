#pragma once
/// Encodes hits as an image with a pixel for each ray.

#include <cstdint>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/query/hit_batch.h"
#include "proto/hit_fields.h"
#include "proto/hit_terms.h"

namespace sightline {

inline constexpr std::string_view kPngMediaType = "image/png";
inline constexpr std::string_view kFloatMapMediaType = "image/x-portable-floatmap";

/// What an image shows, and its format.
///
/// PNG, 16 bits a sample, rows from the top:
///   depth   grey: t / unit, rounded (half to even), 1 to 65535; 0 is a miss
///   node    grey: index of the node in the file plus 1; 0 is a miss
///   normal  red, green, blue: 65535 (n + 1) / 2, rounded; 0 0 0 is a miss
///   visits  grey: number of boxes of trees that the ray was tested with, at most 65535; also for
///   misses
///
/// PFM, little-endian float32, rows from the bottom as the format demands:
///   depth   t rounded to the nearest float32; +inf is a miss
///   node    index of the node in the file; -1 is a miss
///   normal  x, y, z; 0 0 0 is a miss
///   visits  number of boxes
struct HitImage {
  enum class Of { kDepth, kNode, kNormal, kVisits };
  Of of = Of::kDepth;
  bool floats = false;  ///< true: PFM; false: PNG
  double unit = 0.001;  ///< t of one step of a PNG's depth
  std::uint64_t width = 0, height = 0;

  /// The field that the image needs.
  FieldSet fields() const {
    return of == Of::kNode     ? FieldSet{HitField::kNodeId}
           : of == Of::kNormal ? FieldSet{HitField::kNormal}
                               : FieldSet{HitField::kT};
  }
  std::string_view media_type() const { return floats ? kFloatMapMediaType : kPngMediaType; }
};

/// Encodes an image of width * height hits, with the columns of image.fields() in `terms` and
/// `details`; kVisits needs terms.visits instead. Errors: IMAGE_NODES_TOO_MANY (a node's index is
/// above 65534, for PNG), IMAGE_TOO_LARGE (more than a million pixels wide or high), IMAGE_FAILED.
/// Throws std::bad_alloc.
Result<std::string> encode_image(const HitImage& image, const HitBatch& hits,
                                 std::span<const HitDetail> details, const HitTerms& terms);

}  // namespace sightline

// Tests: tests/integration/images_test.py
