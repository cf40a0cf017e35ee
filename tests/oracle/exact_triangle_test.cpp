#include "tests/oracle/exact_triangle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/infinity.h"
#include "tests/oracle/detail_check.h"

namespace sightline::oracle {
namespace {

const Triangle kFlat{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};

std::optional<double> t_of(const Ray& ray, const Triangle& triangle = kFlat) {
  const auto t = least_t(ray, triangle);
  if (!t) return std::nullopt;
  return round_to_double(*t);
}

TEST(ExactTriangle, is_met_in_its_inside_from_both_sides) {
  EXPECT_EQ(t_of({{1, 1, 3}, {0, 0, -2}}), 1.5);
  EXPECT_EQ(t_of({{1, 1, -3}, {0, 0, 2}}), 1.5);
  EXPECT_EQ(t_of({{1, 1, 3}, {0, 0, 2}}), std::nullopt);
  EXPECT_EQ(t_of({{1, 1, 3}, {0, 0, 2}, -2}), -1.5);
}

TEST(ExactTriangle, owns_its_edges_and_corners) {
  for (const Vec3d& p : {Vec3d{0, 0, 1}, Vec3d{4, 0, 1}, Vec3d{0, 4, 1}, Vec3d{2, 0, 1},
                         Vec3d{0, 2, 1}, Vec3d{2, 2, 1}, Vec3d{1, 3, 1}})
    EXPECT_EQ(t_of({p, {0, 0, -1}}), 1.0) << p.x << " " << p.y;
  constexpr double kDenormal = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(t_of({{0, -kDenormal, 1}, {0, 0, -1}}), std::nullopt);
  EXPECT_EQ(t_of({{-kDenormal, 1, 1}, {0, 0, -1}}), std::nullopt);
}

TEST(ExactTriangle, is_met_at_both_closed_limits) {
  EXPECT_EQ(t_of({{1, 1, 3}, {0, 0, -1}, 3, 3}), 3.0);
  EXPECT_EQ(t_of({{1, 1, 3}, {0, 0, -1}, std::nextafter(3, 4), 9}), std::nullopt);
  EXPECT_EQ(t_of({{1, 1, 3}, {0, 0, -1}, 0, std::nextafter(3, 0)}), std::nullopt);
  // t = 1/3 lies between two numbers: neither its rounding nor the number above it is a limit
  // that lets it through from the wrong side.
  const double third = 1.0 / 3;  // rounded down
  EXPECT_EQ(t_of({{1, 1, 1}, {0, 0, -3}, 0, third}), std::nullopt);
  EXPECT_EQ(t_of({{1, 1, 1}, {0, 0, -3}, third, 1}), third);
  EXPECT_EQ(t_of({{1, 1, 1}, {0, 0, -3}, std::nextafter(third, 1), 1}), std::nullopt);
}

TEST(ExactTriangle, is_entered_by_a_ray_in_its_plane) {
  EXPECT_EQ(t_of({{-2, 1, 0}, {1, 0, 0}}), 2.0);
  EXPECT_EQ(t_of({{-2, 0, 0}, {1, 0, 0}}), 2.0);         // along an edge
  EXPECT_EQ(t_of({{-2, 4, 0}, {1, 0, 0}}), 2.0);         // through a corner
  EXPECT_EQ(t_of({{-2, 6, 0}, {1, -1, 0}}), 2.0);        // along the slanted edge
  EXPECT_EQ(t_of({{1, 1, 0}, {1, 0, 0}}), 0.0);          // starts on it
  EXPECT_EQ(t_of({{1, 1, 0}, {1, 0, 0}, -kInf}), -1.0);  // the line enters behind
  EXPECT_EQ(t_of({{1, 1, 0}, {1, 0, 0}, 1.5}), 1.5);     // tmin inside
  EXPECT_EQ(t_of({{1, 1, 0}, {1, 0, 0}, 2}), 2.0);       // tmin where it leaves
  EXPECT_EQ(t_of({{1, 1, 0}, {1, 0, 0}, 2.5}), std::nullopt);
  EXPECT_EQ(t_of({{-2, 1, 0}, {1, 0, 0}, 0, 2}), 2.0);  // tmax where it enters
  EXPECT_EQ(t_of({{-2, 1, 0}, {1, 0, 0}, 0, 1.5}), std::nullopt);
  EXPECT_EQ(t_of({{-2, 5, 0}, {1, 0, 0}}), std::nullopt);
  EXPECT_EQ(t_of({{-2, 1, 1}, {1, 0, 0}}), std::nullopt);  // parallel above it
}

TEST(ExactTriangle, without_area_is_never_met) {
  EXPECT_TRUE(has_no_area({{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}));
  EXPECT_TRUE(has_no_area({{1, 2, 3}, {1, 2, 3}, {4, 5, 6}}));
  EXPECT_FALSE(has_no_area({{0, 0, 0}, {1e-300, 0, 0}, {0, 1e-300, 0}}));
  EXPECT_EQ(t_of({{1, 1, 1}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}), std::nullopt);
}

TEST(ExactTriangle, meets_no_real_t_between_two_equal_infinities) {
  EXPECT_EQ(t_of({{1, 1, 3}, {0, 0, -1}, kInf, kInf}), std::nullopt);
  EXPECT_EQ(t_of({{1, 1, 3}, {0, 0, -1}, -kInf, -kInf}), std::nullopt);
}

TEST(ExactTriangle, may_be_met_at_a_t_beyond_the_float64_range) {
  EXPECT_EQ(t_of({{1, 1, 1e300}, {0, 0, -1e-300}}), kInf);
  EXPECT_EQ(t_of({{1, 1, 1e300}, {0, 0, -1e-300}, 0, std::numeric_limits<double>::max()}),
            std::nullopt);
  EXPECT_EQ(t_of({{1, 1, 1e-300}, {0, 0, -1e300}}), 0.0);
}

TEST(ExactTriangle, is_crossed_once_over_a_shared_edge_or_corner) {
  // A square of four triangles around its middle; the line through the middle, through an inner
  // edge and through an outer edge.
  const Vec3d corners[] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  const auto crossed = [&](const Ray& ray) {
    int count = 0;
    for (int i = 0; i < 4; ++i)
      count += crosses_when_moved(ray, {{0, 0, 0}, corners[i], corners[(i + 1) % 4]}) ? 1 : 0;
    return count;
  };
  for (const double dx : {0.0, 0.5, -0.25}) {
    EXPECT_EQ(crossed({{-dx, 0, 1}, {dx, 0, -1}}), 1);
    EXPECT_EQ(crossed({{0.5 - dx, 0.5, 1}, {dx, 0, -1}}), 1);
  }
  // The moved line lies at x + e, y + e^2: outside at the right and upper edges, inside at the
  // others.
  EXPECT_EQ(crossed({{1, 0.5, 1}, {0, 0, -1}}), 0);
  EXPECT_EQ(crossed({{-1, 0.5, 1}, {0, 0, -1}}), 1);
  EXPECT_EQ(crossed({{0.5, 1, 1}, {0, 0, -1}}), 0);
  EXPECT_EQ(crossed({{0.5, -1, 1}, {0, 0, -1}}), 1);
  EXPECT_EQ(crossed({{-3, 0, 0}, {1, 0, 0}}), 0);  // in the plane
}

TEST(DetailCheck, accepts_the_exact_detail_and_refuses_a_wrong_one) {
  const Ray ray{{1, 1, 3}, {0, 0, -2}};
  const auto t = least_t(ray, kFlat);
  ASSERT_TRUE(t.has_value());
  HitDetail detail{{1, 1, 0}, {0, 0, 1}, 0.25, 0.25, true};
  EXPECT_TRUE(check_detail(ray, kFlat, *t, detail).kept());

  HitDetail off = detail;
  off.position.x = 1 + 2 * 0x1p-52;
  EXPECT_FALSE(check_detail(ray, kFlat, *t, off).position_kept);
  off = detail;
  off.position.x = 1 + 0x1p-52;
  EXPECT_TRUE(check_detail(ray, kFlat, *t, off).kept());
  off = detail;
  off.u = 0.25 + 0x1p-49;
  EXPECT_FALSE(check_detail(ray, kFlat, *t, off).barycentric_kept);
  off = detail;
  off.normal.x = 1.1e-15;
  EXPECT_FALSE(check_detail(ray, kFlat, *t, off).normal_kept);
  off = detail;
  off.front = false;
  EXPECT_TRUE(check_detail(ray, kFlat, *t, off).front_wrong);
}

}  // namespace
}  // namespace sightline::oracle
