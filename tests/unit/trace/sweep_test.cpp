// Swept spheres, capsules and boxes: triangle by triangle against rational arithmetic, and scenes against
// triangle by triangle.

#include "core/trace/search/sweep.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "core/base/infinity.h"
#include "core/geometry/box_oriented.h"
#include "tests/oracle/exact_triangle.h"
#include "tests/oracle/first_contact.h"
#include "tests/oracle/hull_distance.h"
#include "tests/oracle/random.h"
#include "tests/support/random_cases.h"
#include "tests/unit/trace/awkward_scenes.h"

namespace sightline {
namespace {

using oracle::ExactPoint;

/// A triangle and a way towards it, often on a grid, where much is met at edges and corners.
struct Situation {
  Triangle triangle;
  Ray ray;
  Vec3d half;
  Vec3d end;                  ///< of a capsule
  std::array<Vec3d, 3> axes;  ///< of a box
  double scale = 1;

  explicit Situation(oracle::Random& random) {
    const bool is_grid = random.chance(0.7);
    scale = std::ldexp(1.0, random.chance(0.2) ? random.integer(-200, 200) : 0);
    const auto number = [&](int low, int high) {
      return (is_grid ? random.integer(low, high) : random.between(low, high)) * scale;
    };
    const auto point = [&] {
      const double x = number(-5, 5), y = number(-5, 5);
      return Vec3d{x, y, number(-5, 5)};
    };
    triangle = {point(), point(), point()};
    if (random.chance(0.3)) triangle.v0.z = triangle.v1.z = triangle.v2.z = 0;
    ray.origin = point();
    const Vec3d at = random.chance(0.5) ? triangle.v1 : point();
    ray.direction = {at.x - ray.origin.x, at.y - ray.origin.y, at.z - ray.origin.z};
    if (random.chance(0.3)) ray.direction = {0, 0, random.chance(0.5) ? scale : -scale};
    if (ray.direction == Vec3d{}) ray.direction.x = scale;
    if (random.chance(0.5)) ray.origin.z += 8 * scale;
    ray.tmin = random.chance(0.7) ? 0 : random.between(-2, 1);
    ray.tmax = ray.tmin + (random.chance(0.5) ? 20 : random.between(0, 3));
    half = {std::fabs(number(0, 3)), std::fabs(number(0, 3)), std::fabs(number(0, 3))};
    // Often along an edge or the way, often in the triangle's plane, seldom none.
    const Vec3d other = random.chance(0.5) ? triangle.v2 : point();
    const double times = random.chance(0.5) ? 1 : random.integer(-1, 2);
    for (int k = 0; k < 3; ++k) {
      const double step = random.chance(0.3) ? 0 : times * (other[k] - triangle.v1[k]);
      end[k] = ray.origin[k] + step;
    }
    if (random.chance(0.1)) end = ray.origin;
    do {
      const auto part = [&] { return is_grid ? random.integer(-2, 2) : random.between(-1, 1); };
      for (Vec3d& axis : axes) axis = {part(), part(), part()};
      if (random.chance(0.5)) axes = rotated_axes(0.6, 0, 0, 0.8);
    } while (axes_are_dependent(axes));
  }
  SweepPath path() const { return {ray.origin, ray.direction, ray.tmin, ray.tmax}; }
  oracle::Triangle exact() const { return {triangle.v0, triangle.v1, triangle.v2}; }
};

mpq_class square_distance(const Vec3d& p, const Triangle& t) {
  return oracle::hull_square_distance(
      {oracle::exact_point(p)},
      {oracle::exact_point(t.v0), oracle::exact_point(t.v1), oracle::exact_point(t.v2)});
}

bool is_nearest_float64(double t, const mpq_class& exact) {
  const mpq_class off = abs(mpq_class(t) - exact);
  return off <= abs(mpq_class(std::nextafter(t, kInf)) - exact) &&
         off <= abs(mpq_class(std::nextafter(t, -kInf)) - exact);
}

double along(const Vec3d& a, const Vec3d& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// Whether n is a unit vector against the way.
bool is_normal(const Vec3d& n, const Ray& ray) {
  const double length = std::sqrt(along(ray.direction, ray.direction));
  return std::fabs(along(n, n) - 1) <= 1e-15 && along(n, ray.direction) <= 1e-14 * length;
}

/// n . p - n . at, exactly.
mpq_class above(const Vec3d& n, const ExactPoint& p, const Vec3d& at) {
  mpq_class sum = 0;
  for (int k = 0; k < 3; ++k)
    sum += mpq_class(n[k]) * (p[static_cast<std::size_t>(k)] - mpq_class(at[k]));
  return sum;
}

/// The corners of a box at t: what the three planes of each octant share, by Cramer's rule.
std::vector<ExactPoint> corners_of_box(const Situation& s, const SweptBox& box,
                                       const mpq_class& t) {
  const std::array<Vec3d, 3> axes =
      box.axes.value_or(std::array<Vec3d, 3>{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
  const auto minor = [&](std::size_t row, std::size_t column) {
    const auto at = [&](std::size_t i, std::size_t j) {
      return mpq_class(axes[(row + i) % 3][static_cast<int>((column + j) % 3)]);
    };
    return mpq_class(at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1));
  };
  mpq_class all = 0;
  for (std::size_t k = 0; k < 3; ++k) all += mpq_class(axes[0][static_cast<int>(k)]) * minor(0, k);
  std::vector<ExactPoint> corners;
  for (unsigned octant = 0; octant < 8; ++octant) {
    ExactPoint& p = corners.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const int axis = static_cast<int>(k);
      p[k] = mpq_class(s.ray.origin[axis]) + t * mpq_class(s.ray.direction[axis]);
      for (std::size_t row = 0; row < 3; ++row) {
        const mpq_class side = (octant >> row & 1u) != 0
                                   ? mpq_class(s.half[static_cast<int>(row)])
                                   : -mpq_class(s.half[static_cast<int>(row)]);
        p[k] += side * minor(row, k) / all;
      }
    }
  }
  return corners;
}

/// Boxes of one kind against the oracle: whether, when, where, and with which normal.
void judge_boxes(std::uint64_t seed, bool turned, int all) {
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  oracle::Random random(seed);
  std::size_t met = 0, begun = 0;
  const int rounds = test::random_cases(all);
  for (int round = 0; round < rounds; ++round) {
    const Situation s(random);
    SweptBox box{s.half};
    if (turned) box.axes = s.axes;
    const auto contact = BoxContact::first(s.path(), box, s.triangle);
    if (oracle::has_no_area(s.exact())) {
      ASSERT_FALSE(contact);
      continue;
    }
    const auto expected = turned ? oracle::box_contact(s.ray, s.half, s.axes, s.exact())
                                 : oracle::box_contact(s.ray, s.half, s.exact());
    ASSERT_EQ(contact.has_value(), expected.has_value()) << "round " << round;
    if (!contact) continue;
    ++met;
    const double t = contact->rounded();
    ASSERT_TRUE(is_nearest_float64(t, *expected)) << "round " << round;
    // The point is on the triangle and in the box, up to its rounding.
    const Vec3d at = contact->position(s.path(), box, s.triangle);
    const mpq_class tiny = mpq_class(s.scale) * mpq_class(0x1p-44);
    ASSERT_LE(square_distance(at, s.triangle), tiny * tiny) << "round " << round;
    const std::vector<ExactPoint> corners = corners_of_box(s, box, *expected);
    ASSERT_LE(oracle::hull_square_distance({oracle::exact_point(at)}, corners), tiny * tiny)
        << "round " << round;
    const auto normal = contact->normal(s.path(), box, s.triangle);
    if (!normal) {
      ++begun;
      ASSERT_EQ(*expected, mpq_class(s.ray.tmin)) << "round " << round;
      continue;
    }
    ASSERT_TRUE(is_normal(*normal, s.ray)) << "round " << round;
    for (const Vec3d* v : {&s.triangle.v0, &s.triangle.v1, &s.triangle.v2})
      ASSERT_LE(above(*normal, oracle::exact_point(*v), at), tiny) << "round " << round;
    // The components of the normal are rounded once, which turns it by less than 2^-51. Nearly
    // dependent axes make distant corners.
    for (const ExactPoint& corner : corners) {
      const mpq_class far = oracle::hull_square_distance({oracle::exact_point(at)}, {corner});
      const mpq_class turn = mpq_class(std::sqrt(far.get_d()) * 0x1p-51);
      ASSERT_GE(above(*normal, corner, at), -(tiny + turn)) << "round " << round;
    }
  }
  std::printf("%d boxes: met %zu, before tmin %zu, wrong 0\n", rounds, met, begun);
  EXPECT_GT(met, test::random_cases(static_cast<std::size_t>(all)) / 4);
  EXPECT_GT(begun, test::random_cases(static_cast<std::size_t>(all)) / 30);
}

TEST(Sweep, boxes_meet_triangles_when_rational_arithmetic_says) { judge_boxes(171, false, 1500); }
TEST(Sweep, turned_boxes_meet_triangles_when_rational_arithmetic_says) {
  judge_boxes(176, true, 500);
}

/// Capsules or spheres against the oracle: whether, when, where, and with which normal.
void judge_capsules(std::uint64_t seed, bool are_spheres, int all) {
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  oracle::Random random(seed);
  std::size_t met = 0, begun = 0, normals = 0;
  const int rounds = test::random_cases(all);
  for (int round = 0; round < rounds; ++round) {
    const Situation s(random);
    const SweptCapsule capsule{are_spheres ? s.ray.origin : s.end, s.half.x};
    const auto contact = CapsuleContact::first(s.path(), capsule, s.triangle);
    if (oracle::has_no_area(s.exact())) {
      ASSERT_FALSE(contact);
      continue;
    }
    const mpq_class tmin = s.ray.tmin, tmax = s.ray.tmax, radius = capsule.radius;
    const auto meets = [&](const mpq_class& from, const mpq_class& to) {
      return oracle::capsule_meets(s.ray, capsule.to, from, to, radius, s.exact());
    };
    if (!contact) {
      ASSERT_FALSE(meets(tmin, tmax)) << "round " << round;
      continue;
    }
    ++met;
    const double t = contact->rounded();
    // Not before the middle below t, and by the middle above it.
    const mpq_class below = (mpq_class(t) + mpq_class(std::nextafter(t, -kInf))) / 2,
                    over = (mpq_class(t) + mpq_class(std::nextafter(t, kInf))) / 2;
    ASSERT_GE(t, s.ray.tmin);
    ASSERT_LE(t, s.ray.tmax);
    ASSERT_TRUE(meets(tmin, over < tmax ? over : tmax)) << "round " << round;
    const auto normal = contact->normal(s.path(), capsule, s.triangle);
    if (t == s.ray.tmin) {
      ++begun;
    } else {
      const mpq_class before = below - (over - below) / 1024;
      ASSERT_FALSE(before >= tmin && meets(tmin, before)) << "round " << round;
      ASSERT_TRUE(normal || capsule.radius == 0) << "round " << round;
    }
    // On the triangle, and as far from the segment as the radius, or nearer where it began so.
    const Vec3d at = contact->position(s.path(), capsule, s.triangle);
    const mpq_class tiny = mpq_class(s.scale) * mpq_class(0x1p-45);
    ASSERT_LE(square_distance(at, s.triangle), tiny * tiny) << "round " << round;
    std::vector<ExactPoint> ends(capsule.to == s.ray.origin ? 1 : 2);
    for (std::size_t i = 0; i < ends.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        ends[i][static_cast<std::size_t>(k)] = mpq_class((i == 0 ? s.ray.origin : capsule.to)[k]) +
                                               mpq_class(t) * mpq_class(s.ray.direction[k]);
      }
    }
    ASSERT_LE(oracle::hull_square_distance({oracle::exact_point(at)}, ends),
              (radius + tiny) * (radius + tiny))
        << "round " << round;
    if (!normal) continue;
    ++normals;
    ASSERT_TRUE(is_normal(*normal, s.ray)) << "round " << round;
    // The segment is there in the direction of the normal, and the triangle is not.
    ExactPoint there;
    for (int k = 0; k < 3; ++k) {
      there[static_cast<std::size_t>(k)] = mpq_class(at[k]) + radius * mpq_class((*normal)[k]);
    }
    ASSERT_LE(oracle::hull_square_distance({there}, ends), tiny * tiny) << "round " << round;
    for (const Vec3d* v : {&s.triangle.v0, &s.triangle.v1, &s.triangle.v2})
      ASSERT_LE(above(*normal, oracle::exact_point(*v), at), tiny) << "round " << round;
    for (const ExactPoint& end : ends)
      ASSERT_GE(above(*normal, end, at), radius - tiny) << "round " << round;
  }
  std::printf("%d %s: met %zu, at once %zu, normals %zu, wrong 0\n", rounds,
              are_spheres ? "spheres" : "capsules", met, begun, normals);
  EXPECT_GT(met, test::random_cases(static_cast<std::size_t>(all)) / 4);
  EXPECT_GT(begun, test::random_cases(static_cast<std::size_t>(all)) / 30);
  EXPECT_GT(normals, test::random_cases(static_cast<std::size_t>(all)) / 8);
}

TEST(Sweep, spheres_meet_triangles_when_rational_arithmetic_says) {
  judge_capsules(172, true, 3000);
}
TEST(Sweep, capsules_meet_triangles_when_rational_arithmetic_says) {
  judge_capsules(177, false, 1000);
}

/// Of two that are met at the same float64 the order is that of many more digits.
TEST(Sweep, contacts_are_ordered_as_they_are_with_many_digits) {
  oracle::Random random(173);
  std::size_t equal = 0, close = 0;
  for (int round = 0; round < test::random_cases(4000); ++round) {
    const Situation s(random);
    Situation other(random);
    other.triangle.v0 = s.triangle.v0;
    if (random.chance(0.7)) other.triangle.v1 = s.triangle.v1;
    if (s.scale != other.scale) continue;
    const SweptCapsule sphere{round % 2 == 0 ? s.ray.origin : s.end, s.half.x};
    const auto a = CapsuleContact::first(s.path(), sphere, s.triangle);
    const auto b = CapsuleContact::first(s.path(), sphere, other.triangle);
    if (!a || !b) continue;
    const int order = compare(*a, *b);
    ASSERT_EQ(compare(*b, *a), -order);
    ASSERT_EQ(compare(*a, *a), 0);
    if (a->rounded() != b->rounded()) {
      ASSERT_EQ(order, a->rounded() < b->rounded() ? -1 : 1) << "round " << round;
      continue;
    }
    ++close;
    equal += order == 0 ? 1u : 0u;
    if (a->rounded() == s.ray.tmin) continue;
    // Bisect both by 200 more bits.
    const auto first = [&](const Triangle& t) {
      const oracle::Triangle exact{t.v0, t.v1, t.v2};
      mpq_class low = mpq_class(std::nextafter(a->rounded(), -kInf)),
                high = mpq_class(std::nextafter(a->rounded(), kInf));
      for (int i = 0; i < 200; ++i) {
        const mpq_class middle = (low + high) / 2;
        (oracle::capsule_meets(s.ray, sphere.to, s.ray.tmin, middle, sphere.radius, exact) ? high
                                                                                           : low) =
            middle;
      }
      return low;
    };
    if (close > test::random_cases(std::size_t{40})) continue;
    const mpq_class ta = first(s.triangle), tb = first(other.triangle);
    ASSERT_EQ(order, ta < tb ? -1 : ta > tb ? 1 : 0) << "round " << round;
  }
  std::printf("at the same float64 %zu, equal %zu\n", close, equal);
  EXPECT_GT(close, test::random_cases(40u));
}

TEST(Sweep, finds_what_comes_first_triangle_by_triangle) {
  constexpr std::uint64_t kSeed = 174;
  for (const test::Case& c : test::cases()) {
    oracle::Random random(kSeed);
    const auto scene = test::make_scene(c, random);
    const auto instances = static_cast<std::uint32_t>(scene->description().instances.size());
    SweepBatch sweeps;
    while (sweeps.count() < test::random_cases(48u)) {
      const auto w = [&] {
        return scene->world_triangle({static_cast<std::uint32_t>(random.index(instances)),
                                      static_cast<std::uint32_t>(random.index(test::kTriangles))});
      };
      const Triangle from = w(), to = w();
      if (!is_finite(from) || !is_finite(to)) continue;
      Ray ray{from.v0, {to.v1.x - from.v0.x, to.v1.y - from.v0.y, to.v1.z - from.v0.z}};
      for (int k = 0; k < 3; ++k) ray.origin[k] -= 3 * ray.direction[k];
      if (random.chance(0.3)) ray.origin.z -= ray.direction.y;
      if (ray.direction == Vec3d{}) continue;
      if (random.chance(0.3)) ray.tmax = random.between(0, 6);
      const double size = std::fabs(ray.direction.x) * std::exp2(random.integer(-8, -1));
      const Vec3d half{size, size / 2, random.chance(0.2) ? 0 : size * 2};
      const Vec3d& o = ray.origin;
      switch (random.index(4)) {
        case 0:
          sweeps.push_back_sphere(ray, size);
          break;
        case 1:
          sweeps.push_back(ray, SweptBox{half});
          break;
        case 2:
          sweeps.push_back(ray, SweptBox{half, rotated_axes(0.6, 0, 0.48, 0.64)});
          break;
        default:
          sweeps.push_back(ray, SweptCapsule{{o.x + size, o.y, o.z - 3 * size}, size / 2});
      }
    }
    SweepFault fault;
    ASSERT_TRUE(check_sweeps(sweeps, fault)) << fault.code;
    const Deadline deadline = Deadline::never();
    Sweeps search(*scene, nullptr, deadline);
    HitBatch hits;
    hits.resize(sweeps.count());
    std::size_t met = 0;
    for (std::size_t i = 0; i < sweeps.count(); ++i) {
      search.find(sweeps, i, false, hits);
      TriangleId id;
      double t = kInf;
      sweeps.visit(i, [&](const auto& shape) {
        using Contact = typename ContactOf<std::decay_t<decltype(shape)>>::Type;
        std::optional<Contact> best;
        for (std::uint32_t instance = 0; instance < instances; ++instance) {
          for (std::uint32_t k = 0; k < test::kTriangles; ++k) {
            const auto contact =
                Contact::first(sweeps.path(i), shape, scene->world_triangle({instance, k}));
            if (!contact || (best && compare(*contact, *best) >= 0)) continue;
            best = contact;
            id = {instance, k};
          }
        }
        if (best) t = best->rounded();
      });
      ASSERT_EQ(hits.id(i), id) << c.name << " sweep " << i;
      ASSERT_EQ(hits.t[i], t) << c.name << " sweep " << i;
      met += hits.hit(i) ? 1u : 0u;
      search.find(sweeps, i, true, hits);
      ASSERT_EQ(hits.hit(i), id.instance != kNone) << c.name << " sweep " << i;
    }
    std::printf("%s: %zu of %zu met\n", c.name, met, sweeps.count());
  }
}

/// 2^-1074 times 0.3, the way into the mesh, is nothing in float64; 1.5e308 times it is 2e-16.
TEST(Sweep, a_direction_that_vanishes_in_a_tree_still_leads_somewhere) {
  constexpr double kLeast = 0x1p-1074, kLong = 1.5e308;
  const Affine larger = test::affine({3.3, 0, 0, 0, 0, 3.3, 0, 0, 0, 0, 3.3, 0});
  oracle::Random random(175);
  const auto scene =
      test::make_scene({"least", 1e-17f, 0, false, {larger, larger}, Joining::kNever}, random);
  const Deadline deadline = Deadline::never();
  Sweeps search(*scene, nullptr, deadline);
  std::size_t met = 0;
  for (std::uint32_t i = 0; i < test::kTriangles; ++i) {
    const Triangle triangle = scene->world_triangle({0, i});
    if (!is_finite(triangle)) continue;
    Ray ray{triangle.v0, {}};
    const int axis = static_cast<int>(i % 3);
    ray.direction[axis] = kLeast;
    ray.origin[axis] -= kLong * kLeast;
    ray.tmax = 1.75e308;
    SweepBatch sweeps;
    sweeps.push_back_sphere(ray, 0);
    sweeps.push_back(ray, SweptBox{{0, 0, 0}});
    HitBatch hits;
    hits.resize(sweeps.count());
    for (std::size_t k = 0; k < sweeps.count(); ++k) {
      if (!BoxContact::first(sweeps.path(k), {{0, 0, 0}}, triangle)) continue;
      ++met;
      search.find(sweeps, k, true, hits);
      ASSERT_TRUE(hits.hit(k)) << "triangle " << i;
    }
  }
  EXPECT_GT(met, 200u);
}

TEST(Sweep, knows_simple_answers) {
  const Triangle floor{{-9, 0, -9}, {9, 0, -9}, {0, 0, 9}};
  const SweepPath down{{0, 10, 0}, {0, -2, 0}, 0, kInf};
  auto sphere = CapsuleContact::first(down, {down.origin, 3}, floor);
  ASSERT_TRUE(sphere);
  EXPECT_EQ(sphere->rounded(), 3.5);
  EXPECT_EQ(sphere->position(down, {down.origin, 3}, floor), (Vec3d{0, 0, 0}));
  auto box = BoxContact::first(down, {{1, 4, 1}}, floor);
  ASSERT_TRUE(box);
  EXPECT_EQ(box->rounded(), 3);
  EXPECT_EQ(box->position(down, {{1, 4, 1}}, floor), (Vec3d{-1, 0, -1}));
  // Past the corner (9, 0, -9) by 3 and 4: a sphere of 5 touches it, at z = -9.
  const SweepPath past{{12, 4, 91}, {0, 0, -1}, 0, kInf};
  sphere = CapsuleContact::first(past, {past.origin, 5}, floor);
  ASSERT_TRUE(sphere);
  EXPECT_EQ(sphere->rounded(), 100);
  EXPECT_EQ(sphere->position(past, {past.origin, 5}, floor), (Vec3d{9, 0, -9}));
  EXPECT_FALSE(CapsuleContact::first(past, {past.origin, std::nextafter(5.0, 0.0)}, floor));
  EXPECT_FALSE(
      CapsuleContact::first({past.origin, past.direction, 0, 99.99}, {past.origin, 5}, floor));
  // Inside from the beginning.
  sphere = CapsuleContact::first({{0, 1, 0}, {0, 1, 0}, 0.5, 9}, {{0, 1, 0}, 3}, floor);
  ASSERT_TRUE(sphere);
  EXPECT_EQ(sphere->rounded(), 0.5);
  EXPECT_FALSE(CapsuleContact::first({{0, 4, 0}, {0, 1, 0}, 0, 9}, {{0, 4, 0}, 3}, floor))
      << "it has left";
  // 12 above, beside the long edge, 5 off: it comes down to the edge at height 12 with 13.
  const SweepPath beside{{0, 20, -14}, {0, -1, 0}, 0, kInf};
  sphere = CapsuleContact::first(beside, {beside.origin, 13}, floor);
  ASSERT_TRUE(sphere);
  EXPECT_EQ(sphere->rounded(), 8);
  EXPECT_EQ(sphere->position(beside, {beside.origin, 13}, floor), (Vec3d{0, 0, -9}));
  EXPECT_EQ(sphere->normal(beside, {beside.origin, 13}, floor), (Vec3d{0, 12.0 / 13, -5.0 / 13}));
  EXPECT_EQ(box->normal(down, {{1, 4, 1}}, floor), (Vec3d{0, 1, 0}));
  // A capsule that stands comes down with its second end, 4 below the first.
  const SweptCapsule standing{{0, 6, 0}, 3};
  auto capsule = CapsuleContact::first(down, standing, floor);
  ASSERT_TRUE(capsule);
  EXPECT_EQ(capsule->rounded(), 1.5);
  EXPECT_EQ(capsule->position(down, standing, floor), (Vec3d{0, 0, 0}));
  EXPECT_EQ(capsule->normal(down, standing, floor), (Vec3d{0, 1, 0}));
  // One that lies across the long edge touches it 4 beside its axis and 3 below.
  const SweepPath across{{0, 10, -13}, {0, -1, 0}, 0, kInf};
  const SweptCapsule lying{{7, 10, -13}, 5};
  capsule = CapsuleContact::first(across, lying, floor);
  ASSERT_TRUE(capsule);
  EXPECT_EQ(capsule->rounded(), 7);
  EXPECT_EQ(capsule->normal(across, lying, floor), (Vec3d{0, 0.6, -0.8}));
  // One that pierces the floor already.
  capsule = CapsuleContact::first({{0, 1, 0}, {0, 1, 0}, 0, 9}, {{0, -1, 0}, 0.5}, floor);
  ASSERT_TRUE(capsule);
  EXPECT_EQ(capsule->rounded(), 0);
  EXPECT_FALSE(capsule->normal({{0, 1, 0}, {0, 1, 0}, 0, 9}, {{0, -1, 0}, 0.5}, floor));
  // A cube on its edge, by axes at 45 degrees that are sqrt(2) long: 1 / sqrt(2) from its centre.
  const std::array<Vec3d, 3> diagonal{{{1, 1, 0}, {-1, 1, 0}, {0, 0, 1}}};
  const SweptBox cube{{1, 1, 1}, diagonal};
  box = BoxContact::first(down, cube, floor);
  ASSERT_TRUE(box);
  EXPECT_EQ(box->rounded(), 4.5);
  EXPECT_EQ(box->normal(down, cube, floor), (Vec3d{0, 1, 0}));
  EXPECT_EQ(box->position(down, cube, floor), (Vec3d{0, 0, -1}));
}

}  // namespace
}  // namespace sightline
