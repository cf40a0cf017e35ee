#pragma once
/// Rays of JSON as nearly everybody writes them, read straight from the text: numbers, the keys of
/// a ray without escapes, blanks anywhere.
///
/// Precondition of all: behind the text stands a byte that is no digit, and kPlainPadding bytes can
/// be read.

#include <cstddef>
#include <string>
#include <string_view>

#include "core/query/ray_batch.h"

namespace sightline {

/// Reads the object at `at` and moves it behind the end; a row without limits leaves those of `ray`
/// as they are. False, with `at` and `ray` anywhere, for all that is written otherwise or is wrong:
/// a slower reader then says what it is.
bool scan_plain_ray(const char*& at, Ray& ray);

/// The large arrays of a body of rays.
struct PlainArrays {
  bool has_rays = false, has_origins = false, has_directions = false;
  RayBatch rays;     ///< of `has_rays` all columns, else those that are there
  std::string rest;  ///< the body with empty arrays in their place
};

/// Takes "rays", "origins" and "directions" out of a body where all of them that it has are plain
/// and have at most `most` rays. False, with `arrays` anywhere, where there are none, or another
/// reader is needed for them.
bool take_plain_arrays(std::string_view body, std::size_t most, double default_tmin,
                       PlainArrays& arrays);

}  // namespace sightline

// Tests: tests/unit/proto/ray_json_test.cpp
