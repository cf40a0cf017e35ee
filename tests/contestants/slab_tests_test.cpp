/// Where each text's formula goes wrong, and that ours does not. What a contestant gets wrong here
/// is expected: should one ever be right, it was copied wrongly.

#include "tests/contestants/slab_tests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/geometry/ray_box.h"
#include "tests/oracle/random.h"
#include "tests/unit/geometry/ray_box_golden.h"

namespace sightline::contestants {
namespace {

using golden::kBox;
using golden::kGoldenCases;
using golden::kMiss;

const golden::GoldenCase& golden_case(std::string_view name) {
  for (const auto& c : kGoldenCases) {
    if (c.name == name) return c;
  }
  throw std::invalid_argument("no such case");
}

SlabAnswer ask(std::string_view contestant, std::string_view name) {
  const golden::GoldenCase& c = golden_case(name);
  return slab_test(contestant).test({c.origin, c.direction}, kBox);
}

/// Names of the golden cases whose verdict or t the contestant gets wrong.
std::vector<std::string> failures_of(std::string_view contestant) {
  std::vector<std::string> names;
  for (const auto& c : kGoldenCases) {
    const SlabAnswer answer = slab_test(contestant).test({c.origin, c.direction}, kBox);
    const bool right = answer.hit == (c.t != kMiss) && (!answer.hit || answer.t == c.t);
    if (!right) names.emplace_back(c.name);
  }
  return names;
}

using Names = std::vector<std::string>;

TEST(SlabTests, divide_and_swap_answers_every_golden_case) {
  EXPECT_EQ(failures_of("slab_swap_divide"), Names{});
}

TEST(SlabTests, the_inverted_parallel_test_loses_parallel_rays) {
  for (const char* name : {"along +x", "in the plane y = 3 (touching)", "along an edge"}) {
    EXPECT_FALSE(ask("inverted_parallel", name).hit) << name;
  }
  const Ray outside{{-10, 5, 9}, {1, 0, 0}};
  EXPECT_TRUE(slab_test("inverted_parallel").test(outside, kBox).hit) << "and invents one";
}

TEST(SlabTests, the_slides_second_iteration_loses_the_sign) {
  for (const char* name : {"along -x", "negative diagonal"}) {
    const SlabAnswer answer = ask("slide_iteration_2", name);
    EXPECT_EQ(answer.enter, -12) << name;
    EXPECT_EQ(answer.exit, -6) << name;
    EXPECT_FALSE(answer.hit) << name;
  }
}

TEST(SlabTests, comparing_d_with_zero_takes_the_wrong_branch_for_minus_zero) {
  EXPECT_FALSE(ask("d_ge_0", "direction (1,-0,0)").hit);
  EXPECT_FALSE(ask("d_ge_0", "in the plane y = 3 with -0").hit);
  EXPECT_TRUE(ask("d_ge_0", "along +x").hit) << "+0 is right";
}

TEST(SlabTests, asking_for_a_positive_entry_answers_the_far_face_on_the_near_one) {
  EXPECT_EQ(ask("tgmin_positive", "origin on the entry face").t, 6);
}

TEST(SlabTests, returning_the_entry_answers_behind_the_origin) {
  EXPECT_EQ(ask("entry_returned", "origin inside, negative diagonal").t, -4);
  EXPECT_EQ(ask("entry_returned", "origin on the exit face, leaving").t, -6);
}

TEST(SlabTests, the_example_code_in_three_dimensions_answers_infinity_in_a_plane_with_minus_zero) {
  const SlabAnswer answer = ask("example_code_3d", "in the plane y = 3 with -0");
  EXPECT_TRUE(answer.hit) << "the exit is NaN, which no comparison calls a miss";
  EXPECT_EQ(answer.t, std::numeric_limits<double>::infinity());
  EXPECT_EQ(ask("example_code_3d", "in the plane y = 3 (touching)").t, 8) << "+0 is right";
  EXPECT_EQ(failures_of("example_code_3d"),
            (Names{"in the plane y = 3 with -0", "origin on the entry face"}))
      << "it asks for a positive entry too";
}

TEST(SlabTests, williams_loses_an_origin_on_the_exit_face) {
  EXPECT_FALSE(ask("williams2005", "origin on the exit face, leaving").hit)
      << "its limits are open";
  // In the plane of an x face the first product is 0 * inf, and NaN is where it starts.
  const Ray in_face{{-2, -10, 0}, {0, 1, 0}};
  EXPECT_FALSE(slab_test("williams2005").test(in_face, kBox).hit);
  EXPECT_EQ(ray_box(in_face.origin, in_face.direction, 0, kMiss, kBox).t, 7);
}

TEST(SlabTests, min_and_max_lose_rays_in_the_plane_of_a_face) {
  EXPECT_FALSE(ask("branchless_min_max", "in the plane y = 3 (touching)").hit);
  EXPECT_FALSE(slab_test("fma_inverse").test({{-10, 1, 0}, {1, 0, 0}}, kBox).hit)
      << "inf - inf, for parallel rays between the planes too";
}

/// Counts rays that touch an edge exactly, and how many of them a contestant loses.
template <class Make>
int misses(std::string_view contestant, int count, Make make) {
  oracle::Random random(2005);
  int lost = 0;
  for (int i = 0; i < count; ++i) {
    Box3d box;
    const Ray ray = make(random, box);
    const RayBoxAnswer answer = ray_box(ray.origin, ray.direction, ray.tmin, ray.tmax, box);
    EXPECT_EQ(answer.outcome, RayBoxOutcome::kHit);
    EXPECT_EQ(answer.t_enter, answer.t_exit);
    lost += slab_test(contestant).test(ray, box).hit ? 0 : 1;
  }
  return lost;
}

/// Grazes an edge: enters x where it leaves y, at a t of k / m.
Ray grazing(oracle::Random& random, Box3d& box) {
  const double m = random.integer(1, 99), k = random.integer(1, 99);
  const Vec3d step{static_cast<double>(random.integer(1, 1000)),
                   static_cast<double>(random.integer(1, 1000)), 0};
  box = {{0, -8, -1}, {8, 0, 1}};
  return {{-k * step.x, -k * step.y, 0}, {m * step.x, m * step.y, 0}};
}

/// The same with differences that need more than 53 bits, in the ratio of 1 to 3.
Ray grazing_with_long_differences(oracle::Random& random, Box3d& box) {
  const double b = std::ldexp(std::floor(random.unit() * 0x1p48), -40);
  const double o = -std::ldexp(std::floor(random.unit() * 0x1p48), -60);
  const double d = std::ldexp(std::floor(1 + random.unit() * 0x1p20), -20);
  box = {{b, 0, -1}, {b + 8, 3 * b, 1}};
  return {{o, 3 * o, 0}, {d, 3 * d, 0}};
}

TEST(SlabTests, inverses_lose_rays_that_graze_an_edge) {
  for (const char* name : {"williams2005", "branchless_min_max"}) {
    const int lost = misses(name, 2000, grazing);
    std::printf("%s loses %d of 2000 grazing rays\n", name, lost);
    EXPECT_GT(lost, 100) << name;
  }
  EXPECT_EQ(misses("slab_swap_divide", 2000, grazing), 0)
      << "division of exact differences is exact";
}

TEST(SlabTests, division_loses_rays_whose_differences_were_rounded) {
  const int lost = misses("slab_swap_divide", 2000, grazing_with_long_differences);
  std::printf("slab_swap_divide loses %d of 2000 grazing rays\n", lost);
  EXPECT_GT(lost, 100);
}

TEST(SlabTests, padding_hits_boxes_that_the_ray_passes) {
  EXPECT_EQ(misses("ize2013_padded", 2000, grazing), 0) << "it loses none";
  oracle::Random random(2013);
  int invented = 0;
  for (int i = 0; i < 2000; ++i) {
    Box3d box;
    const Ray ray = grazing(random, box);
    box.min.x = 0x1p-52;  // the edge moves past the ray
    const RayBoxAnswer answer = ray_box(ray.origin, ray.direction, 0, kMiss, box);
    EXPECT_EQ(answer.outcome, RayBoxOutcome::kApart);
    invented += slab_test("ize2013_padded").test(ray, box).hit ? 1 : 0;
  }
  std::printf("ize2013_padded invents %d of 2000 passing rays\n", invented);
  EXPECT_GT(invented, 1000);
}

TEST(SlabTests, pairs_of_slabs_ignore_what_the_third_axis_says) {
  EXPECT_TRUE(slab_test("pairwise_2d").test({{-10, 1, 9}, {1, 0.125, 0}}, kBox).hit);
  EXPECT_EQ(ray_box({-10, 1, 9}, {1, 0.125, 0}, 0, kMiss, kBox).outcome, RayBoxOutcome::kBeside);
}

}  // namespace
}  // namespace sightline::contestants
