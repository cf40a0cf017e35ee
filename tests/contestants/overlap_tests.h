#pragma once
/// Triangle-box tests as papers give them, in plain floating point.

#include <span>
#include <string_view>

#include "core/geometry/box3.h"
#include "core/geometry/triangle.h"

namespace sightline::contestants {

struct OverlapTest {
  std::string_view name;
  std::string_view about;
  bool (*test)(const Triangle& triangle, const Box3d& box);
};

/// akenine_moeller2001_float32, akenine_moeller2001_float64.
std::span<const OverlapTest> overlap_tests();

}  // namespace sightline::contestants
