#pragma once
/// Reads rays from JSON text in its usual form: numbers, keys without escapes, white space
/// anywhere. It is a fast path; other text is left to JsonReader.
///
/// Preconditions: the byte after the text is not a digit, and kPlainPadding bytes after the text
/// are readable.

#include <cstddef>
#include <string>
#include <string_view>

#include "core/query/ray_batch.h"

namespace sightline {

/// Reads the ray, an object, at `at`, and moves `at` to the end of the object. Limits that the
/// object does not have stay unchanged in `ray`. Returns false, with `at` and `ray` unspecified,
/// for other forms and for errors; JsonReader then reads the text again and reports the error.
bool scan_plain_ray(const char*& at, Ray& ray);

/// The large arrays of a body of rays.
struct PlainArrays {
  bool has_rays = false, has_origins = false, has_directions = false;
  RayBatch rays;     ///< with has_rays all columns, else those of the arrays present
  std::string rest;  ///< the body with empty arrays instead
};

/// Reads "rays", "origins" and "directions" from a body, if all that are present have the usual
/// form and at most `most` rays. Returns false, with `arrays` unspecified, if there are none, or if
/// JsonReader must read them. default_tmin: of rows without a tmin.
bool take_plain_arrays(std::string_view body, std::size_t most, double default_tmin,
                       PlainArrays& arrays);

}  // namespace sightline

// Tests: tests/unit/proto/ray_json_test.cpp
