#include "tests/oracle/box_oracle.h"

#include <gtest/gtest.h>

#include "core/base/infinity.h"
#include "tests/oracle/random.h"
#include "tests/support/random_cases.h"

namespace sightline::oracle {
namespace {

const Box3d kGolden{{-2, -3, -4}, {4, 3, 2}};
constexpr std::array<Vec3d, 3> kAxes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

TEST(BoxOracle, answers_the_golden_cases_of_the_lecture_notes) {
  struct Case {
    Vec3d origin, direction;
    bool hit;
    double enter, leave;
  };
  constexpr double k64th = 0.015625;
  for (const Case& c :
       {Case{{-10, 0, 0}, {1, k64th, k64th}, true, 8, 14},
        Case{{-10, 0, 0}, {1, 0, 0}, true, 8, 14}, Case{{10, 0, 0}, {-1, 0, 0}, true, 6, 12},
        Case{{-10, 0, 0}, {1, -0.0, 0}, true, 8, 14}, Case{{-10, 5, 0}, {1, 0, 0}, false, 0, 0},
        Case{{-10, 3, 0}, {1, 0, 0}, true, 8, 14}, Case{{-10, 3, 0}, {1, -0.0, 0}, true, 8, 14},
        Case{{0, 0, 0}, {1, 0, 0}, true, -2, 4}, Case{{0, 0, 0}, {-1, -0.5, -0.25}, true, -4, 2},
        Case{{10, 0, 0}, {1, k64th, k64th}, true, -12, -6},
        Case{{-2, 0, 0}, {1, k64th, k64th}, true, 0, 6},
        Case{{4, 0, 0}, {1, k64th, k64th}, true, -6, 0}, Case{{-10, 3, 2}, {1, 0, 0}, true, 8, 14},
        Case{{-3, -4, -5}, {1, 1, 1}, true, 1, 7},
        Case{{10, 1, 1}, {-1, -0.0625, -0.0625}, true, 6, 12}}) {
    const LineTimes times = line_times({c.origin, c.direction}, axis_aligned(kGolden));
    ASSERT_EQ(times.hit, c.hit);
    if (!c.hit) continue;
    EXPECT_EQ(*times.enter, mpq_class(c.enter));
    EXPECT_EQ(*times.leave, mpq_class(c.leave));
  }
}

TEST(BoxOracle, tells_inside_from_surface_from_outside) {
  const ExactBox box = axis_aligned(kGolden);
  EXPECT_TRUE(line_times({{0, 0, 0}, {1, 0, 0}}, box).origin_inside);
  EXPECT_TRUE(line_times({{4, 3, 2}, {1, 0, 0}}, box).origin_on_surface);
  EXPECT_FALSE(line_times({{4, 3, 3}, {1, 0, 0}}, box).origin_on_surface);
}

TEST(BoxOracle, leaves_an_unbounded_axis_out) {
  const ExactBox flat = axis_aligned({{-2, -3, -kInf}, {4, 3, kInf}});
  const LineTimes along = line_times({{0, 0, 7}, {0, 0, 1}}, flat);
  EXPECT_TRUE(along.hit);
  EXPECT_FALSE(along.enter.has_value() || along.leave.has_value());
  EXPECT_EQ(*line_times({{-10, 0, 1e300}, {1, 0, 5}}, flat).enter, 8);
}

/// For axis-aligned boxes and lines there is a second road: the candidate points.
bool overlap_by_candidates(const Box3d& box, const Triangle& w) {
  // A corner of the triangle in the box, or an edge of the triangle through a face of the box, or
  // an edge of the box through the triangle.
  const Vec3d v[3] = {w.v0, w.v1, w.v2};
  for (int i = 0; i < 3; ++i) {
    const Vec3d& a = v[i];
    const Vec3d& b = v[(i + 1) % 3];
    const Vec3d d{b.x - a.x, b.y - a.y, b.z - a.z};  // exact for the small integers used here
    if (d == Vec3d{0, 0, 0}) {
      if (a.x >= box.min.x && a.x <= box.max.x && a.y >= box.min.y && a.y <= box.max.y &&
          a.z >= box.min.z && a.z <= box.max.z)
        return true;
      continue;
    }
    const LineTimes times = line_times({a, d}, axis_aligned(box));
    if (times.hit && *times.enter <= 1 && *times.leave >= 0) return true;
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 4; ++side) {
      Vec3d from = box.min, d{0, 0, 0};
      const int a = (axis + 1) % 3, b = (axis + 2) % 3;
      if ((side & 1) != 0) from[a] = box.max[a];
      if ((side & 2) != 0) from[b] = box.max[b];
      d[axis] = box.max[axis] - box.min[axis];
      if (d[axis] != 0 && least_t({from, d, 0, 1}, w)) return true;
    }
  }
  return false;
}

TEST(BoxOracle, clips_triangles_as_candidate_points_say) {
  Random random(21);
  int touching = 0;
  for (int i = 0; i < test::random_cases(30000); ++i) {
    const auto point = [&] {
      const double x = random.integer(-3, 3), y = random.integer(-3, 3);
      return Vec3d{x, y, static_cast<double>(random.integer(-3, 3))};
    };
    Box3d box;
    box.include(point());
    box.include(point());
    if (!(box.min.x < box.max.x && box.min.y < box.max.y && box.min.z < box.max.z)) continue;
    const Triangle triangle{point(), point(), point()};
    const bool truth = overlap_by_candidates(box, triangle);
    ASSERT_EQ(overlap(axis_aligned(box), triangle), truth) << i;
    touching += truth ? 1 : 0;

    // The same box as an oriented one, both ways, and turned by an exact rotation.
    const Vec3d center{0.5 * (box.min.x + box.max.x), 0.5 * (box.min.y + box.max.y),
                       0.5 * (box.min.z + box.max.z)};
    const Vec3d half{0.5 * (box.max.x - box.min.x), 0.5 * (box.max.y - box.min.y),
                     0.5 * (box.max.z - box.min.z)};
    ASSERT_EQ(overlap(oriented_by_slabs(center, kAxes, half), triangle), truth) << i;
    ASSERT_EQ(overlap(oriented_by_edges(center, kAxes, half), triangle), truth) << i;
  }
  EXPECT_GT(touching, test::random_cases(3000));
}

TEST(BoxOracle, knows_both_meanings_of_axes_that_are_not_orthonormal) {
  // Axes (1,0,0) (1,1,0) (0,0,1): by edges the parallelogram of x = a + b, y = b; by slabs the set
  // |x| <= 1, |x + y| <= 1.
  const std::array<Vec3d, 3> skew{{{1, 0, 0}, {1, 1, 0}, {0, 0, 1}}};
  const Ray probe{{1.75, 0.75, 0}, {0, 0, 1}};
  EXPECT_TRUE(line_times(probe, oriented_by_edges({0, 0, 0}, skew, {1, 1, 1})).hit);
  EXPECT_FALSE(line_times(probe, oriented_by_slabs({0, 0, 0}, skew, {1, 1, 1})).hit);
  const Ray other{{1, -2, 0}, {0, 0, 1}};
  EXPECT_TRUE(line_times(other, oriented_by_slabs({0, 0, 0}, skew, {1, 1, 1})).hit);
  EXPECT_FALSE(line_times(other, oriented_by_edges({0, 0, 0}, skew, {1, 1, 1})).hit);
}

TEST(BoxOracle, counts_a_touch_at_a_single_point) {
  const ExactBox box = axis_aligned({{0, 0, 0}, {1, 1, 1}});
  EXPECT_TRUE(overlap(box, {{1, 1, 1}, {2, 1, 1}, {1, 2, 1}}));
  EXPECT_TRUE(overlap(box, {{2, 0, 0}, {0, 2, 0}, {2, 2, 5}}));  // the edge x + y = 2 at (1,1,0)
  EXPECT_FALSE(overlap(box, {{2, 0x1p-1074, 0}, {0x1p-1074, 2, 0}, {2, 2, 5}}));
  EXPECT_FALSE(overlap(box, {{2.0000000000000004, 0, 0}, {0, 2.0000000000000004, 0}, {2, 2, 5}}));
  // A box that is a point, and a triangle through it.
  EXPECT_TRUE(overlap(axis_aligned({{1, 1, 1}, {1, 1, 1}}), {{0, 0, 0}, {3, 3, 3}, {1, 0, 0}}));
  EXPECT_FALSE(overlap(axis_aligned({{1, 1, 2}, {1, 1, 2}}), {{0, 0, 0}, {3, 3, 3}, {1, 0, 0}}));
}

}  // namespace
}  // namespace sightline::oracle
