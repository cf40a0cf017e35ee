/// Triangles that touch a box exactly, and how many of them plain floating point loses.

#include "tests/contestants/overlap_tests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "core/geometry/triangle_box.h"
#include "tests/oracle/random.h"

namespace sightline::contestants {
namespace {

/// Triangles with one edge in a face of the box and the rest outside: how many of 2000 are lost.
template <class Real>
int lost_when_touching_a_face(const OverlapTest& contestant) {
  oracle::Random random(2001);
  int lost = 0;
  for (int i = 0; i < 2000; ++i) {
    // Numbers that the contestant's own format holds: the input is not what it gets wrong.
    const auto number = [&](double low, double high) {
      return static_cast<double>(static_cast<Real>(random.between(low, high)));
    };
    const Box3d box{{number(-9, 1), number(-9, 1), number(-9, 1)},
                    {number(2, 3), number(2, 3), number(2, 3)}};
    const double face = box.max.x;
    const Triangle triangle{{face, number(1, 2), number(1, 2)},
                            {face, number(1, 2), number(1, 2)},
                            {number(3, 4), number(1, 2), number(1, 2)}};
    EXPECT_TRUE(triangle_meets_box(triangle, box));
    lost += contestant.test(triangle, box) ? 0 : 1;
  }
  std::printf("%s loses %d of 2000 touching triangles\n", contestant.name.data(), lost);
  return lost;
}

TEST(OverlapTests, a_rounded_centre_loses_triangles_that_touch_a_face) {
  EXPECT_GT(lost_when_touching_a_face<float>(overlap_tests()[0]), 20);
  EXPECT_GT(lost_when_touching_a_face<double>(overlap_tests()[1]), 20);
}

}  // namespace
}  // namespace sightline::contestants
