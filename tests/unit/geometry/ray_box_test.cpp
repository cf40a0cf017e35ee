/// Ray against box, row by row of the lecture notes that the project grew from. The row numbers in
/// the comments are theirs.

#include "core/geometry/ray_box.h"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/base/infinity.h"
#include "tests/oracle/random.h"
#include "tests/support/float_text.h"
#include "tests/unit/geometry/ray_box_golden.h"

namespace sightline {
namespace {

using golden::kBox;
using test::same_bits;

template <class Box>
RayBoxAnswer ray(const Vec3d& o, const Vec3d& d, const Box& box, double tmin = 0,
                 double tmax = kInf) {
  return ray_box(o, d, tmin, tmax, box);
}
template <class Box>
RayBoxAnswer line(const Vec3d& o, const Vec3d& d, const Box& box) {
  return ray_box(o, d, -kInf, kInf, box);
}

std::string faces(const RayBoxAnswer& answer) {
  std::string text;
  for (std::size_t i = 0; i < answer.faces.count; ++i) {
    if (i > 0) text += ' ';
    text += answer.faces.face[i].upper ? '+' : '-';
    text += "xyz"[answer.faces.face[i].axis];
  }
  return text;
}
std::string face(const RayBoxAnswer& answer) { return faces(answer).substr(0, 2); }

bool hits(const RayBoxAnswer& answer) { return answer.outcome == RayBoxOutcome::kHit; }
TEST(RayBox, answers_the_golden_cases) {
  for (const golden::GoldenCase& c : golden::kGoldenCases) {
    SCOPED_TRACE(c.name);
    const RayBoxAnswer answer = ray(c.origin, c.direction, kBox);
    EXPECT_EQ(hits(answer), c.t != golden::kMiss);
    const RayBoxAnswer whole = line(c.origin, c.direction, kBox);
    EXPECT_EQ(hits(whole), c.enter != golden::kMiss);
    if (hits(whole)) {
      EXPECT_TRUE(same_bits(whole.t_enter, c.enter));
      EXPECT_TRUE(same_bits(whole.t_exit, c.exit));
    }
    if (hits(answer)) {
      EXPECT_TRUE(same_bits(answer.t, c.t)) << answer.t;
      EXPECT_EQ(face(answer), c.face);
      EXPECT_EQ(faces(answer), c.faces);
    }
  }
}

// Row 1.
TEST(RayBox, takes_a_two_dimensional_box_as_one_with_an_open_axis) {
  const Box3d flat{{-2, -3, -kInf}, {4, 3, kInf}};
  const RayBoxAnswer answer = ray({-10, 0, 1e300}, {1, 0.25, 7}, flat);
  EXPECT_TRUE(hits(answer));
  EXPECT_EQ(answer.t_enter, 8);
  EXPECT_EQ(answer.t_exit, 12);
  EXPECT_FALSE(hits(ray({-10, 4, 0}, {1, 0.25, 7}, flat)));
  EXPECT_TRUE(hits(ray({0, 0, 0}, {0, 0, 1}, flat)));
}

// Row 1.
TEST(RayBox, has_no_t_where_the_ray_runs_in_the_open) {
  const Box3d everything{{-kInf, -kInf, -kInf}, {kInf, kInf, kInf}};
  const RayBoxAnswer answer = ray({1, 2, 3}, {4, 5, 6}, everything);
  EXPECT_TRUE(hits(answer));
  EXPECT_TRUE(answer.inside);
  EXPECT_EQ(answer.t_enter, -kInf);
  EXPECT_EQ(answer.t_exit, kInf);
  EXPECT_EQ(answer.t, kInf);
  EXPECT_EQ(answer.faces.count, 0);
}

// Row 2.
TEST(RayBox, gives_the_t_of_all_six_planes) {
  const PlaneTs planes = ray_box_planes({-10, 1, 0}, {1, -0.5, 0}, kBox);
  EXPECT_EQ(planes[0], 8);
  EXPECT_EQ(planes[1], 14);
  EXPECT_EQ(planes[2], 8);
  EXPECT_EQ(planes[3], -4);
  EXPECT_FALSE(planes[4].has_value()) << "the ray is parallel to z";
  EXPECT_FALSE(planes[5].has_value());
}

// Row 3: the three figures.
TEST(RayBox, misses_hits_and_misses_the_box_of_the_three_figures) {
  const Box3d square{{1, 1, -kInf}, {3, 3, kInf}};
  const RayBoxAnswer ray_1 = ray({0, 2.5, 0}, {1, 1, 0}, square);
  EXPECT_EQ(ray_1.outcome, RayBoxOutcome::kApart);
  EXPECT_EQ(ray_1.apart, (std::array<std::uint8_t, 2>{0, 1})) << "y is left before x is entered";
  const RayBoxAnswer ray_2 = ray({0, 0.5, 0}, {1, 1, 0}, square);
  EXPECT_TRUE(hits(ray_2));
  EXPECT_EQ(ray_2.t, 1);
  EXPECT_EQ(ray_2.t_exit, 2.5);
  const RayBoxAnswer ray_3 = ray({0, -2.5, 0}, {1, 1, 0}, square);
  EXPECT_EQ(ray_3.outcome, RayBoxOutcome::kApart);
  EXPECT_EQ(ray_3.apart, (std::array<std::uint8_t, 2>{0, 1})) << "x is left before y is entered";
}

// Row 3.
TEST(RayBox, names_the_slabs_that_exclude_each_other) {
  EXPECT_EQ(ray({-10, -10, 0}, {1, 4, 0}, kBox).apart, (std::array<std::uint8_t, 2>{0, 1}));
  EXPECT_EQ(ray({0, -10, -10}, {0, 4, 1}, kBox).apart, (std::array<std::uint8_t, 2>{1, 2}));
  EXPECT_EQ(ray({-10, 0, -10}, {1, 0, 4}, kBox).apart, (std::array<std::uint8_t, 2>{0, 2}));
}

// Row 4: `txmin > tymax or tymin > txmax` in rational numbers.
TEST(RayBox, agrees_with_the_pairwise_test_in_two_dimensions) {
  oracle::Random random(4);
  int met = 0;
  for (int i = 0; i < 20000; ++i) {
    const Box3d box{{-1, -1, -kInf}, {random.between(-1, 1), random.between(-1, 1), kInf}};
    const Vec3d o = random.point(-3, 3);
    Vec3d d = random.direction();
    if (i % 2 == 0) d = {box.min.x - o.x, box.max.y - o.y, 0};
    const auto t = [&](int k, double plane) {
      return mpq_class((mpq_class(plane) - mpq_class(o[k])) / mpq_class(d[k]));
    };
    mpq_class txmin = t(0, box.min.x), txmax = t(0, box.max.x);
    mpq_class tymin = t(1, box.min.y), tymax = t(1, box.max.y);
    if (txmin > txmax) std::swap(txmin, txmax);
    if (tymin > tymax) std::swap(tymin, tymax);
    const bool miss = txmin > tymax || tymin > txmax;
    ASSERT_EQ(hits(line(o, d, box)), !miss) << i;
    met += miss ? 0 : 1;
  }
  EXPECT_GT(met, 5000);
}

// Rows 5 and 6: all octants, entered and left through mirrored faces.
TEST(RayBox, swaps_the_planes_in_every_octant) {
  for (int octant = 0; octant < 8; ++octant) {
    const auto mirror = [&](double x, int k) { return ((octant >> k) & 1) != 0 ? -x : x; };
    const Vec3d o{mirror(-10, 0), mirror(0.5, 1), mirror(0.25, 2)};
    const Vec3d d{mirror(2, 0), mirror(0.125, 1), mirror(0.0625, 2)};
    Box3d box{{0, 0, 0}, {0, 0, 0}};
    for (int k = 0; k < 3; ++k) {
      box.min[k] = std::min(mirror(kBox.min[k], k), mirror(kBox.max[k], k));
      box.max[k] = std::max(mirror(kBox.min[k], k), mirror(kBox.max[k], k));
    }
    const RayBoxAnswer answer = ray(o, d, box);
    ASSERT_TRUE(hits(answer)) << octant;
    EXPECT_EQ(answer.t_enter, 4) << octant;
    EXPECT_EQ(answer.t_exit, 7) << octant;
    EXPECT_EQ(faces(answer), (octant & 1) != 0 ? "+x" : "-x") << octant;
  }
}

// Rows 7 and 8.
TEST(RayBox, rejects_when_the_exit_is_behind_the_origin) {
  const RayBoxAnswer answer = ray({10, 0, 0}, {1, 0.015625, 0.015625}, kBox);
  EXPECT_EQ(answer.outcome, RayBoxOutcome::kBehind);
  EXPECT_EQ(answer.t_enter, -12);
  EXPECT_EQ(answer.t_exit, -6);
}

// Rows 7 and 18.
TEST(RayBox, reports_hits_behind_the_origin_for_a_line) {
  const RayBoxAnswer answer = line({10, 0, 0}, {1, 0.015625, 0.015625}, kBox);
  EXPECT_TRUE(hits(answer));
  EXPECT_EQ(answer.t, -12);
  EXPECT_EQ(faces(answer), "-x");
}

// Row 9.
TEST(RayBox, answers_the_exit_when_the_origin_is_inside_and_gives_both) {
  for (const double tmin : {0.0, -kInf}) {
    const RayBoxAnswer answer = ray_box({0, 0, 0}, {-1, -0.5, -0.25}, tmin, kInf, kBox);
    EXPECT_TRUE(answer.inside);
    EXPECT_FALSE(answer.on_surface);
    EXPECT_EQ(answer.t_enter, -4);
    EXPECT_EQ(answer.t_exit, 2);
    EXPECT_EQ(answer.t, 2);
    EXPECT_EQ(faces(answer), "-x");
  }
}

// Row 9.
TEST(RayBox, has_no_t_when_the_ray_ends_inside) {
  const RayBoxAnswer answer = ray({0, 0, 0}, {1, 0, 0}, kBox, 0, 3);
  EXPECT_TRUE(hits(answer));
  EXPECT_EQ(answer.t, kInf);
  EXPECT_EQ(answer.faces.count, 0);
  EXPECT_EQ(ray({0, 0, 0}, {1, 0, 0}, kBox, 0, 4).t, 4) << "limits are closed";
}

TEST(RayBox, answers_the_exit_when_the_entry_is_before_tmin) {
  const RayBoxAnswer answer = ray({-10, 0, 0}, {1, 0, 0}, kBox, 9);
  EXPECT_FALSE(answer.inside) << "that is about the origin";
  EXPECT_EQ(answer.t, 14);
  EXPECT_EQ(faces(answer), "+x");
}

// Row 10.
TEST(RayBox, hits_the_face_that_the_origin_lies_on) {
  struct Case {
    Vec3d o, d;
    const char* faces;
  };
  const Case cases[] = {{{-2, 0, 0}, {1, 0, 0}, "-x"},         {{-2, 0, 0}, {-1, 0, 0}, "-x"},
                        {{4, 0, 0}, {1, 0, 0}, "+x"},          {{4, 0, 0}, {-1, 0, 0}, "+x"},
                        {{0, 3, 0}, {1, 0, 0}, "+y"},          {{0, 3, 2}, {0, 1, 1}, "+y +z"},
                        {{-2, -3, -4}, {1, 1, 1}, "-x -y -z"}, {{4, 3, 0}, {1, 0, 0}, "+x +y"},
                        {{-2, 3, 0}, {0, 0, 1}, "-x +y"}};
  for (const Case& c : cases) {
    for (const double tmin : {0.0, -kInf}) {
      const RayBoxAnswer answer = ray_box(c.o, c.d, tmin, kInf, kBox);
      EXPECT_TRUE(hits(answer)) << c.faces;
      EXPECT_TRUE(answer.on_surface) << c.faces;
      EXPECT_FALSE(answer.inside) << c.faces;
      EXPECT_TRUE(same_bits(answer.t, 0.0)) << c.faces;
      EXPECT_EQ(faces(answer), c.faces);
    }
  }
}

// Row 11, named after the inverted test: "if the origin is between the planes, reject".
TEST(RayBox, does_not_invert_the_test_of_a_parallel_ray) {
  for (const double zero : {0.0, -0.0}) {
    EXPECT_EQ(ray({-10, 0, 0}, {1, zero, zero}, kBox).t, 8);
    const RayBoxAnswer outside = ray({-10, 5, 0}, {1, zero, zero}, kBox);
    EXPECT_EQ(outside.outcome, RayBoxOutcome::kBeside);
    EXPECT_EQ(outside.apart, (std::array<std::uint8_t, 2>{1, 1}));
  }
}

// Row 12.
TEST(RayBox, misses_when_a_parallel_ray_runs_below_the_slab) {
  EXPECT_FALSE(hits(ray({-10, std::nextafter(-3.0, -4.0), 0}, {1, 0, 0}, kBox)));
}
TEST(RayBox, hits_when_a_parallel_ray_runs_between_the_planes_or_in_one) {
  for (const double y : {-3.0, std::nextafter(-3.0, 0.0), 0.0, 3.0}) {
    EXPECT_EQ(ray({-10, y, 0}, {1, 0, 0}, kBox).t, 8) << y;
  }
}
TEST(RayBox, misses_when_a_parallel_ray_runs_above_the_slab) {
  EXPECT_FALSE(hits(ray({-10, std::nextafter(3.0, 4.0), 0}, {1, 0, 0}, kBox)));
}

// Row 13.
TEST(RayBox, keeps_the_sign_that_the_slides_second_iteration_loses) {
  const RayBoxAnswer answer = ray({10, 0, 0}, {-1, 0, 0}, kBox);
  EXPECT_EQ(answer.t_enter, 6);
  EXPECT_EQ(answer.t_exit, 12);
}

// Rows 14 and 17: what multiplies an infinite inverse by zero meets NaN here.
TEST(RayBox, meets_no_nan_in_the_planes_of_faces) {
  for (const double y : {-3.0, 3.0}) {
    for (const double x : {-2.0, 1.0, 4.0}) {
      for (const double zero : {0.0, -0.0}) {
        const RayBoxAnswer answer = ray({x, y, -10}, {zero, zero, 1}, kBox);
        EXPECT_TRUE(hits(answer));
        EXPECT_EQ(answer.t, 6);
        EXPECT_EQ(face(answer), "-z");
      }
    }
  }
}

// Row 15.
TEST(RayBox, answers_the_same_for_both_signs_of_zero) {
  oracle::Random random(15);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d o{static_cast<double>(random.integer(-5, 5)),
                  static_cast<double>(random.integer(-5, 5)),
                  static_cast<double>(random.integer(-5, 5))};
    const int k = random.integer(0, 2);
    Vec3d d{1, 1, 1};
    d[k] = 0;
    Vec3d negative = d;
    negative[k] = -0.0;
    const RayBoxAnswer a = line(o, d, kBox);
    const RayBoxAnswer b = line(o, negative, kBox);
    EXPECT_EQ(a.outcome, b.outcome);
    EXPECT_TRUE(same_bits(a.t, b.t) && same_bits(a.t_enter, b.t_enter));
    EXPECT_EQ(faces(a), faces(b));
  }
}

// Row 17: no answer holds NaN, whatever finite numbers come in.
TEST(RayBox, never_answers_nan) {
  oracle::Random random(17);
  for (int i = 0; i < 20000; ++i) {
    Box3d box;
    box.include(Vec3d{random.any_double(), random.any_double(), random.any_double()});
    box.include(Vec3d{random.any_double(), random.any_double(), random.any_double()});
    const Vec3d o{random.any_double(), random.any_double(), random.any_double()};
    const Vec3d d{random.any_double(), random.chance(0.5) ? 0 : random.any_double(), 0};
    const RayBoxAnswer answer = line(o, d, box);
    EXPECT_FALSE(std::isnan(answer.t) || std::isnan(answer.t_enter) || std::isnan(answer.t_exit));
    for (const std::optional<double>& t : ray_box_planes(o, d, box)) {
      EXPECT_FALSE(t && std::isnan(*t));
    }
  }
}

// Row 19.
TEST(RayBox, takes_oriented_boxes) {
  OrientedBox box{{1, 0, 0}, {3, 3, 3}, {}};
  box.axes = rotated_axes(0, 0, 0, 1);
  const RayBoxAnswer straight = ray({-10, 0, 0}, {1, 0, 0}, box);
  EXPECT_EQ(straight.t, 8);
  EXPECT_EQ(faces(straight), "-x");

  // A quarter turn about z: local x points along world y.
  box.half = {1, 5, 1};
  box.axes = {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
  const RayBoxAnswer turned = ray({-10, 0, 0}, {1, 0, 0}, box);
  EXPECT_EQ(turned.t, 6);
  EXPECT_EQ(faces(turned), "+y");
  const Vec3d normal = face_normal(box, turned.faces.face[0]);
  EXPECT_EQ(normal, (Vec3d{-1, 0, 0}));
  EXPECT_TRUE(same_bits(normal.y, 0.0)) << "no -0";
}

// Row 19: an axis is taken as it is, so that a longer one makes a thinner box.
TEST(RayBox, takes_the_axes_of_an_oriented_box_as_they_are) {
  const OrientedBox box{{0, 0, 0}, {6, 1, 1}, {{{2, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  EXPECT_EQ(ray({-10, 0, 0}, {1, 0, 0}, box).t_enter, 7);
  const OrientedBox skewed{{0, 0, 0}, {1, 1, 1}, {{{1, 1, 0}, {0, 1, 0}, {0, 0, 1}}}};
  EXPECT_EQ(ray({-10, 0.5, 0}, {1, 0, 0}, skewed).t_enter, 8.5);
  EXPECT_TRUE(axes_are_dependent({{{1, 0, 0}, {0, 1, 0}, {1, 1, 0}}}));
  EXPECT_FALSE(axes_are_dependent({{{1, 0, 0}, {0, 1, 0}, {1, 1, 1e-300}}}));
}

// Row 19: a corner of a turned box, met exactly.
TEST(RayBox, touches_the_corner_of_an_oriented_box) {
  const OrientedBox diamond{{0, 0, 0}, {1, 1, 1}, {{{1, 1, 0}, {1, -1, 0}, {0, 0, 1}}}};
  const RayBoxAnswer touch = ray({1, -10, 0}, {0, 1, 0}, diamond);
  EXPECT_TRUE(hits(touch));
  EXPECT_EQ(touch.t_enter, 10);
  EXPECT_EQ(touch.t_exit, 10);
  EXPECT_EQ(faces(touch), "+y +x");
  EXPECT_FALSE(hits(ray({std::nextafter(1.0, 2.0), -10, 0}, {0, 1, 0}, diamond)));
}

// Row 21.
TEST(RayBox, lists_every_face_of_edges_and_corners_in_the_order_x_y_z) {
  EXPECT_EQ(faces(ray({-10, -11, 0}, {1, 1, 0}, kBox)), "-x -y");
  EXPECT_EQ(faces(ray({0, -11, -12}, {0, 1, 1}, kBox)), "-y -z");
  EXPECT_EQ(faces(ray({12, 11, 10}, {-1, -1, -1}, kBox)), "+x +y +z");
  EXPECT_EQ(face_normal(kBox, {1, true}), (Vec3d{0, 1, 0}));
  EXPECT_EQ(face_normal(kBox, {0, false}), (Vec3d{-1, 0, 0}));
}

// Row 21: the face is one that the ray crosses at t, not one that it runs along.
TEST(RayBox, prefers_the_face_that_produced_t_over_one_it_runs_along) {
  EXPECT_EQ(faces(ray({-2, -10, 0}, {0, 1, 0}, kBox)), "-y -x");
}

// Rows 22 and 23: an epsilon of 1e-4 is a hundred boxes wide at one scale and nothing at the other.
TEST(RayBox, needs_no_epsilon_at_scale_1e_minus_6_and_1e6) {
  for (const double scale : {0x1p-20, 1.0, 0x1p20}) {
    Box3d box;
    for (int k = 0; k < 3; ++k) {
      box.min[k] = kBox.min[k] * scale;
      box.max[k] = kBox.max[k] * scale;
    }
    const double y = 3 * scale;
    const RayBoxAnswer touching = ray({-10 * scale, y, 0}, {1, 0, 0}, box);
    EXPECT_EQ(faces(touching), "-x +y") << scale;
    EXPECT_EQ(touching.t, 8 * scale);
    EXPECT_FALSE(hits(ray({-10 * scale, std::nextafter(y, kInf), 0}, {1, 0, 0}, box))) << scale;
    const RayBoxAnswer below = ray({-10 * scale, std::nextafter(y, 0), 0}, {1, 0, 0}, box);
    EXPECT_EQ(faces(below), "-x") << "not the edge, at scale " << scale;
  }
}

// Row 28: a miss is a miss, not a number.
TEST(RayBox, says_that_it_misses_instead_of_returning_minus_one) {
  const RayBoxAnswer behind = line({-1, 0, 0}, {1, 0, 0}, Box3d{{-2, -1, -1}, {-2, 1, 1}});
  EXPECT_TRUE(hits(behind)) << "t = -1 is a hit of the line";
  EXPECT_EQ(behind.t, -1);
  EXPECT_EQ(ray({-1, 0, 0}, {1, 0, 0}, Box3d{{-2, -1, -1}, {-2, 1, 1}}).outcome,
            RayBoxOutcome::kBehind);
}

TEST(RayBox, keeps_limits_closed) {
  EXPECT_TRUE(hits(ray({-10, 0, 0}, {1, 0, 0}, kBox, 0, 8)));
  EXPECT_EQ(ray({-10, 0, 0}, {1, 0, 0}, kBox, 0, std::nextafter(8.0, 0.0)).outcome,
            RayBoxOutcome::kBeyond);
  EXPECT_EQ(ray({-10, 0, 0}, {1, 0, 0}, kBox, 14, 20).t, 14);
  EXPECT_EQ(ray({-10, 0, 0}, {1, 0, 0}, kBox, std::nextafter(14.0, 15.0), 20).outcome,
            RayBoxOutcome::kBehind);
}

TEST(RayBox, survives_differences_and_quotients_beyond_float64) {
  constexpr double kMax = std::numeric_limits<double>::max();
  const RayBoxAnswer wide = ray({-kMax, 0, 0}, {1, 0, 0}, Box3d{{kMax, -1, -1}, {kMax, 1, 1}});
  EXPECT_TRUE(hits(wide));
  EXPECT_EQ(wide.t_enter, kInf) << "2^1025 rounds so";
  EXPECT_EQ(faces(wide), "-x +x");
  const double tiny = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(ray({0, 0, 0}, {tiny, 0, 0}, Box3d{{tiny, 0, 0}, {3 * tiny, 0, 0}}).t_exit, 3);
}

}  // namespace
}  // namespace sightline
