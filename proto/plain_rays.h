#pragma once
/// Rays of JSON as nearly everybody writes them, read straight from the text: numbers, the keys of
/// a ray without escapes, blanks anywhere.
///
/// Each reads what stands at `at` and moves it behind the end. False, with `at` and the output
/// anywhere, for all that is written otherwise or is wrong: a slower reader then says what it is.
/// Precondition: behind the text stands a byte that is no digit, and kPlainPadding bytes can be
/// read.

#include <cstddef>

#include "core/query/ray_batch.h"

namespace sightline {

/// One object; a row without limits leaves those of `ray` as they are.
bool scan_plain_ray(const char*& at, Ray& ray);
/// An array of them. `rays` is empty before; each ray without a tmin has `default_tmin`.
bool scan_plain_rays(const char*& at, std::size_t most, double default_tmin, RayBatch& rays);
/// An array of 3n numbers.
bool scan_plain_vectors(const char*& at, std::size_t most, Column<double>& x, Column<double>& y,
                        Column<double>& z);

}  // namespace sightline
