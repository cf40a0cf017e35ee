#pragma once
/// The golden cases of ray against box: box min (-2,-3,-4), max (4,3,2), entry and exit by rational
/// arithmetic.

#include <array>
#include <limits>

#include "core/geometry/box3.h"
#include "core/query/ray_batch.h"

namespace sightline::golden {

inline constexpr double kMiss = std::numeric_limits<double>::infinity();
inline constexpr Box3d kBox{{-2, -3, -4}, {4, 3, 2}};

struct GoldenCase {
  const char* name;
  Vec3d origin, direction;
  double enter, exit;  ///< of the line; kMiss when the line misses
  double t;            ///< of the ray with tmin = 0; kMiss
  const char* face;    ///< "" for a miss
  const char* faces;   ///< all that hold the point at t
};

inline constexpr std::array<GoldenCase, 15> kGoldenCases{{
    {"from the front, oblique", {-10, 0, 0}, {1, 0.015625, 0.015625}, 8, 14, 8, "-x", "-x"},
    {"along +x", {-10, 0, 0}, {1, 0, 0}, 8, 14, 8, "-x", "-x"},
    {"along -x", {10, 0, 0}, {-1, 0, 0}, 6, 12, 6, "+x", "+x"},
    {"direction (1,-0,0)", {-10, 0, 0}, {1, -0.0, 0}, 8, 14, 8, "-x", "-x"},
    {"parallel, outside the slab", {-10, 5, 0}, {1, 0, 0}, kMiss, kMiss, kMiss, "", ""},
    {"in the plane y = 3 (touching)", {-10, 3, 0}, {1, 0, 0}, 8, 14, 8, "-x", "-x +y"},
    {"in the plane y = 3 with -0", {-10, 3, 0}, {1, -0.0, 0}, 8, 14, 8, "-x", "-x +y"},
    {"origin inside, along +x", {0, 0, 0}, {1, 0, 0}, -2, 4, 4, "+x", "+x"},
    {"origin inside, negative diagonal", {0, 0, 0}, {-1, -0.5, -0.25}, -4, 2, 2, "-x", "-x"},
    {"box behind", {10, 0, 0}, {1, 0.015625, 0.015625}, -12, -6, kMiss, "", ""},
    {"origin on the entry face", {-2, 0, 0}, {1, 0.015625, 0.015625}, 0, 6, 0, "-x", "-x"},
    {"origin on the exit face, leaving", {4, 0, 0}, {1, 0.015625, 0.015625}, -6, 0, 0, "+x", "+x"},
    {"along an edge", {-10, 3, 2}, {1, 0, 0}, 8, 14, 8, "-x", "-x +y +z"},
    {"through a corner", {-3, -4, -5}, {1, 1, 1}, 1, 7, 1, "-x", "-x -y -z"},
    {"negative diagonal", {10, 1, 1}, {-1, -0.0625, -0.0625}, 6, 12, 6, "+x", "+x"},
}};

}  // namespace sightline::golden
