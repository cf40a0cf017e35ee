#pragma once
/// Hits as a picture, a pixel for each ray.

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

/// The content and the format of a picture.
///
/// PNG, 16 bits a sample, rows from the top:
///   depth   grey: t / unit, rounded (to even in the middle), 1 to 65535; 0 is a miss
///   node    grey: the node's index in the file plus 1; 0 is a miss
///   normal  red, green, blue: 65535 (n + 1) / 2, rounded; 0 0 0 is a miss
///   visits  grey: boxes of trees that the ray was tested with, at most 65535; misses have visits too
///
/// PFM, little-endian float32, rows from the bottom, as the format has it:
///   depth   t rounded to the nearest float32; +inf is a miss
///   node    the node's index; -1 is a miss
///   normal  x, y, z; 0 0 0 is a miss
///   visits  how many boxes
struct HitImage {
  enum class Of { kDepth, kNode, kNormal, kVisits };
  Of of = Of::kDepth;
  bool floats = false;  ///< PFM
  double unit = 0.001;  ///< of t, for each step of a PNG
  std::uint64_t width = 0, height = 0;

  FieldSet fields() const {
    return of == Of::kNode     ? FieldSet{HitField::kNodeId}
           : of == Of::kNormal ? FieldSet{HitField::kNormal}
                               : FieldSet{HitField::kT};
  }
  std::string_view media_type() const { return floats ? kFloatMapMediaType : kPngMediaType; }
};

/// width * height slots of hits, and of what image.fields() needs; kVisits: of terms.visits. Errors: IMAGE_NODES_TOO_MANY (a
/// node's number is beyond 65534 in a PNG), IMAGE_TOO_LARGE (more than a million pixels wide or
/// high), IMAGE_FAILED. Throws std::bad_alloc.
Result<std::string> encode_image(const HitImage& image, const HitBatch& hits,
                                 std::span<const HitDetail> details, const HitTerms& terms);

}  // namespace sightline

// Tests: tests/integration/images_test.py
