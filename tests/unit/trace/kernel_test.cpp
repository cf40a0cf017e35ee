// Every kernel against the exact predicate on every triangle, on small scenes made to be awkward.

#include "core/trace/kernel/kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <random>

#include "core/base/infinity.h"
#include "core/geometry/exact_hit.h"
#include "core/trace/decision.h"
#include "tests/support/random_cases.h"
#include "tests/unit/trace/awkward_scenes.h"

namespace sightline {
namespace {

using test::affine;

struct SceneCase {
  const char* name;
  float scale = 1;
  float shift = 0;
  bool integer = false;        ///< coordinates on a small grid: many exact edge and corner aims
  std::vector<Affine> places;  ///< empty: one identity
  Joining joining = Joining::kMeasured;
};

/// Every case of several placements once more with each of them entered on its own.
std::vector<SceneCase> with_each_on_its_own(std::vector<SceneCase> cases) {
  for (std::size_t i = cases.size(); i-- > 0;) {
    if (cases[i].places.empty()) continue;
    cases.push_back(cases[i]);
    cases.back().joining = Joining::kNever;
  }
  return cases;
}

std::shared_ptr<const Scene> make_scene(const SceneCase& c, std::mt19937_64& random) {
  auto mesh = std::make_shared<Mesh>();
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::uniform_int_distribution<int> grid(-3, 3);
  const auto coordinate = [&] {
    return (c.integer ? static_cast<float>(grid(random)) : uniform(random)) * c.scale + c.shift;
  };
  for (std::uint32_t i = 0; i < 60; ++i)
    mesh->positions.own().push_back({coordinate(), coordinate(), coordinate()});
  std::uniform_int_distribution<std::uint32_t> index(0, 59);
  for (int i = 0; i < 3 * 90; ++i) mesh->indices.own().push_back(index(random));
  mesh->primitives.push_back({0, 90, 0, 0xffffffffu});
  SceneDescription description;
  description.meshes.push_back(mesh);
  description.nodes.push_back({});
  if (c.places.empty()) description.instances.push_back({});
  for (const Affine& place : c.places) description.instances.push_back({0, 0, place});
  auto scene = Scene::build(std::move(description), TreeQuality::kHigh, c.joining);
  EXPECT_TRUE(scene.ok());
  return *scene;
}

RayBatch make_rays(const SceneCase& c, const Scene& scene, std::mt19937_64& random,
                   std::size_t count) {
  RayBatch rays;
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::uniform_int_distribution<std::uint32_t> instance(
      0, static_cast<std::uint32_t>(scene.description().instances.size()) - 1);
  std::uniform_int_distribution<std::uint32_t> triangle(0, 89);
  std::uniform_int_distribution<int> kind(0, 11);
  const auto any_bits = [&] { return std::bit_cast<double>(random()); };
  const double s = static_cast<double>(c.scale);
  const double shift = static_cast<double>(c.shift);
  while (rays.size() < count) {
    const WorldTriangle w = scene.world_triangle({instance(random), triangle(random)});
    Ray ray;
    const int k = kind(random);
    Vec3d target = w.v0;
    if (k == 1) target = {(w.v0.x + w.v1.x) / 2, (w.v0.y + w.v1.y) / 2, (w.v0.z + w.v1.z) / 2};
    if (k == 2)
      target = {(w.v0.x + w.v1.x + w.v2.x) / 3, (w.v0.y + w.v1.y + w.v2.y) / 3,
                (w.v0.z + w.v1.z + w.v2.z) / 3};
    if (!is_finite(target)) continue;
    ray.origin = {uniform(random) * 3 * s + shift, uniform(random) * 3 * s + shift,
                  uniform(random) * 3 * s + shift};
    if (c.integer)
      ray.origin = {std::round(ray.origin.x), std::round(ray.origin.y), std::round(ray.origin.z)};
    if (k == 3) ray.origin = w.v1;                 // from a corner
    if (k == 4) target = w.v1, ray.origin = w.v0;  // along an edge
    ray.direction = {target.x - ray.origin.x, target.y - ray.origin.y, target.z - ray.origin.z};
    if (k == 5) ray.direction = {0, 0, uniform(random)};  // along an axis
    if (k == 6) ray.tmin = -2, ray.tmax = 1;              // behind, and closed at the hit
    if (k == 7) ray.tmin = 1;
    if (k == 8) {  // from far away
      ray.origin = {ray.origin.x + ray.direction.x * -1e8, ray.origin.y + ray.direction.y * -1e8,
                    ray.origin.z + ray.direction.z * -1e8};
    }
    if (k == 9) ray.tmin = -kInf;
    if (k >= 10) {  // numbers of any size: much of this overflows
      if (k == 10) ray.origin = {any_bits(), any_bits(), any_bits()};
      ray.direction = {any_bits(), any_bits(), any_bits()};
      ray.tmin = -kInf;
    }
    RayBatch one;
    one.push_back(ray);
    RayFault fault;
    if (check_rays(one, fault)) rays.push_back(ray);
  }
  return rays;
}

TEST(Kernel, answers_like_the_exact_predicate_on_every_triangle) {
  const Affine shear = affine({1, 3, 0, 2, 0, 1, 5, 0, 0, 0, 0.25, -1});
  const Affine mirror = affine({-1, 0, 0, 0.5, 0, 2, 0, 0.1, 0, 0, 1, 0});
  const Affine flat = affine({1, 0, 0, 0, 0, 0, 0, 0.5, 0, 0, 1, 0});
  const Affine nearly_flat = affine({1, 0, 0, 0, 0, 1e-12, 0, 0.5, 0, 0, 1, 0});
  const Affine turn = affine({0.6, -0.8, 0, 0.3, 0.8, 0.6, 0, 0, 0, 0, 1, 1.7});
  const Affine huge = affine({1e200, 0, 0, 0, 0, 1e199, 0, 3, 0, 0, 1e200, 1});
  const Affine small = affine({1e-30, 0, 0, 0, 0, 1e-30, 0, 0, 0, 0, 1e-29, 0});
  const Affine small_turn = affine({0.6, -0.8, 0, 1e-20, 0.8, 0.6, 0, 0, 0, 0, 1, 0});
  const Affine small_mirror = affine({-1, 0, 0, 0, 0, 2, 0, 1e-20, 0, 0, 1, 0});
  const std::vector<SceneCase> cases = with_each_on_its_own({
      {"uniform", 1, 0, false, {}},
      {"grid", 1, 0, true, {}},
      {"tiny", 1e-30f, 0, false, {}},
      {"denormal", 1e-40f, 0, false, {}},
      {"huge", 1e30f, 0, false, {}},
      {"shifted", 1, 1e6f, false, {}},
      {"grid in one place", 1, 0, true, {shear}},
      {"uniform in many places",
       1,
       0,
       false,
       {Affine{}, shear, mirror, flat, nearly_flat, turn, turn}},
      {"grid in many places", 1, 0, true, {turn, Affine{}, mirror, flat, shear, Affine{}}},
      {"tiny in many places", 1e-20f, 0, false, {small_turn, small_mirror, Affine{}}},
      {"grid in one place many times", 1, 0, true, {Affine{}, Affine{}, Affine{}}},
      {"one far larger than many", 1, 0, false, {turn, mirror, Affine{}, huge, shear}},
      {"one far smaller than many", 1, 0, true, {turn, small, Affine{}, mirror}},
  });
  constexpr std::uint64_t kSeed = 42;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  for (const SceneCase& c : cases) {
    std::mt19937_64 random(kSeed);
    const auto scene = make_scene(c, random);
    const RayBatch rays = make_rays(c, *scene, random, test::random_cases<std::size_t>(400));
    const auto instances = static_cast<std::uint32_t>(scene->description().instances.size());

    HitBatch truth;
    truth.resize(rays.size());
    std::vector<std::vector<TriangleId>> all(rays.size());
    std::vector<std::uint64_t> crossings(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Ray ray = rays[i];
      ExactT best;
      TriangleId id;
      std::vector<std::pair<ExactT, TriangleId>> met;
      for (std::uint32_t k = 0; k < instances; ++k) {
        for (std::uint32_t j = 0; j < 90; ++j) {
          ExactT t;
          if (!exact_hit(ray.origin, ray.direction, ray.tmin, ray.tmax,
                         scene->world_triangle({k, j}), t))
            continue;
          met.emplace_back(t, TriangleId{k, j});
          if (exact_crossing(ray.origin, ray.direction, scene->world_triangle({k, j})))
            ++crossings[i];
          if (id.instance == kNone || compare(t, best) < 0) best = t, id = {k, j};
        }
      }
      std::stable_sort(met.begin(), met.end(),
                       [](const auto& a, const auto& b) { return compare(a.first, b.first) < 0; });
      for (const auto& hit : met) all[i].push_back(hit.second);
      truth.t[i] = id.instance == kNone ? kInf : best.rounded();
      truth.instance[i] = id.instance;
      truth.triangle[i] = id.triangle;
    }

    for (const Kernel& kernel : supported_kernels()) {
      HitBatch hits;
      hits.resize(rays.size());
      TraceCounts counts;
      kernel.closest(*scene, rays, 0, rays.size(), hits, counts);
      std::vector<std::uint8_t> occluded(rays.size());
      kernel.any(*scene, rays, 0, rays.size(), occluded.data(), counts);
      std::vector<HitDetail> details(rays.size());
      kernel.details(*scene, rays, 0, rays.size(), hits, details.data(), counts);
      std::vector<Vec3d> normals(rays.size());
      kernel.normals(*scene, 0, rays.size(), hits, normals.data());
      for (std::size_t i = 0; i < rays.size(); ++i) {
        if (!truth.hit(i)) continue;
        const HitDetail exact = hit_detail(*scene, rays[i], truth.id(i));
        ASSERT_EQ(details[i].position, exact.position) << c.name << ", " << kernel.name;
        ASSERT_EQ(details[i].normal, exact.normal) << c.name << ", " << kernel.name;
        ASSERT_EQ(normals[i], exact.normal) << c.name << ", " << kernel.name;
        ASSERT_EQ(details[i].u, exact.u) << c.name << ", " << kernel.name;
        ASSERT_EQ(details[i].v, exact.v) << c.name << ", " << kernel.name;
        ASSERT_EQ(details[i].front, exact.front) << c.name << ", " << kernel.name;
      }
      std::vector<std::uint64_t> totals(rays.size());
      std::vector<std::uint64_t> once(rays.size());
      HitBatch lists;
      kernel.all(*scene, rays, 0, rays.size(), {Crossings::kEvery, 1000, totals.data(), &lists},
                 counts);
      kernel.all(*scene, rays, 0, rays.size(), {Crossings::kOnce, 0, once.data(), nullptr}, counts);
      std::size_t at = 0;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(totals[i], all[i].size()) << c.name << ", " << kernel.name << ", ray " << i;
        ASSERT_EQ(once[i], crossings[i]) << c.name << ", " << kernel.name << ", ray " << i;
        for (const TriangleId& id : all[i])
          ASSERT_EQ(lists.id(at++), id) << c.name << ", ray " << i;
      }
      for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(hits.id(i), truth.id(i)) << c.name << ", " << kernel.name << ", ray " << i;
        ASSERT_EQ(hits.t[i], truth.t[i]) << c.name << ", " << kernel.name << ", ray " << i;
        ASSERT_EQ(occluded[i], truth.hit(i) ? 1 : 0)
            << c.name << ", " << kernel.name << ", ray " << i;
      }
      std::size_t met = 0;
      for (std::size_t i = 0; i < rays.size(); ++i) met += truth.hit(i) ? 1u : 0u;
      std::printf(
          "%-24s %-9s %zu of %zu rays meet something; blocks %llu, exact %llu, compares %llu\n",
          c.name, std::string(kernel.name).c_str(), met, rays.size(),
          static_cast<unsigned long long>(counts.blocks),
          static_cast<unsigned long long>(counts.decisions.exact_hits),
          static_cast<unsigned long long>(counts.decisions.exact_compares));
    }
  }
}

/// Rows of a picture that looks along -z from in front of the scene, some of them with rays that
/// are parallel, some with limits of their own, one with a ray that goes elsewhere. Directions meet
/// zeros of both signs, octants and largest axes change inside a row. `per_unit` columns side by
/// side are as far apart as the scene is deep.
RayBatch make_rows(const SceneCase& c, std::size_t rows, std::size_t columns,
                   double per_unit = 64) {
  const double s = static_cast<double>(c.scale) * (c.integer ? 3 : 1);
  const double shift = static_cast<double>(c.shift);
  RayBatch rays;
  const std::size_t middle_column = columns / 2, middle_row = rows / 2;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const double x =
          (static_cast<double>(column) - static_cast<double>(middle_column)) / per_unit;
      const double y = (static_cast<double>(row) - static_cast<double>(middle_row)) / 16;
      Ray ray{{shift, shift, shift + 2 * s}, {x * s, y * s, -s}};
      if (row % 5 == 1) ray = {{shift + x * s, shift + y * s, shift + 2 * s}, {0, -0.0, -s}};
      if (row % 5 == 2) ray.tmin = 1 + x, ray.tmax = 2.5 - x / 2;
      if (row % 5 == 3) ray.direction = {-0.0, y * s, x * s - s / 4};
      if (row % 5 == 4 && column == 70) ray.origin.z = shift + 1e9 * s;
      rays.push_back(ray);
    }
  }
  return rays;
}

/// Rays from near each other in directions of half the octants, some of which point along an axis,
/// start far away, or have limits of their own.
RayBatch make_scattered_rays(const SceneCase& c, std::size_t count, std::mt19937_64& random) {
  const double s = static_cast<double>(c.scale) * (c.integer ? 3 : 1);
  const double shift = static_cast<double>(c.shift);
  std::uniform_real_distribution<double> any(-1, 1);
  RayBatch rays;
  for (std::size_t i = 0; i < count; ++i) {
    const auto near = [&] { return shift + 0.2 * s * any(random); };
    Ray ray{{near(), near(), near()},
            {s * std::abs(any(random)), s * any(random), s * any(random)}};
    if (i % 53 == 7) ray.direction = {-0.0, s, 0};
    if (i % 61 == 8) ray.direction = {s, -s, s};
    if (i % 97 == 9) ray.origin.z = shift + 1e9 * s;
    if (i % 5 == 3) ray.tmin = 0.25, ray.tmax = 0.75;
    rays.push_back(ray);
  }
  return rays;
}

/// `make_rays(case, random)` for each; `least_together` of the rays are to go in packets.
template <class MakeRays>
void expect_together_as_alone(const std::vector<SceneCase>& cases, double least_together,
                              const MakeRays& make_rays) {
  for (const SceneCase& c : cases) {
    std::mt19937_64 random(7);
    const auto scene = make_scene(c, random);
    const RayBatch rays = make_rays(c, random);
    for (const Kernel& kernel : supported_kernels()) {
      HitBatch together, alone;
      together.resize(rays.size());
      alone.resize(rays.size());
      std::vector<std::uint8_t> any_together(rays.size()), any_alone(rays.size());
      TraceCounts counts, ignored;
      kernel.closest(*scene, rays, 0, rays.size(), together, counts);
      kernel.any(*scene, rays, 0, rays.size(), any_together.data(), ignored);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        kernel.closest(*scene, rays, i, i + 1, alone, ignored);
        kernel.any(*scene, rays, i, i + 1, any_alone.data(), ignored);
      }
      std::size_t met = 0;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        met += alone.hit(i) ? 1u : 0u;
        ASSERT_EQ(together.id(i), alone.id(i)) << c.name << ", " << kernel.name << ", ray " << i;
        ASSERT_EQ(together.t[i], alone.t[i]) << c.name << ", " << kernel.name << ", ray " << i;
        ASSERT_EQ(any_together[i], any_alone[i]) << c.name << ", " << kernel.name << ", ray " << i;
        ASSERT_EQ(any_alone[i], alone.hit(i) ? 1 : 0) << c.name << ", ray " << i;
      }
      EXPECT_GT(met, rays.size() / 4) << c.name;
      if (kernel.name.starts_with("avx")) {
        EXPECT_GE(static_cast<double>(counts.packet_rays),
                  least_together * static_cast<double>(rays.size()))
            << c.name << ", " << kernel.name;
      }
      std::printf("%-24s %-9s %zu of %zu rays meet something, %llu went in packets\n", c.name,
                  std::string(kernel.name).c_str(), met, rays.size(),
                  static_cast<unsigned long long>(counts.packet_rays));
    }
  }
}

TEST(Kernel, answers_neighbouring_rays_together_as_each_alone) {
  const Affine sheared = affine({1, 0.5, 0, 0, 0, 1, 0.25, 0, 0, 0, 0.5, 0});
  const Affine mirrored = affine({-1, 0, 0, 0.5, 0, 2, 0, 0.1, 0, 0, 1, 0});
  // So small that vectors leave it to make_box_ray; a row of rays meets its box.
  const Affine speck = affine({1e-150, 0, 0, 0, 0, 1e-150, 0, 0, 0, 0, 1e-150, 0});
  const std::vector<SceneCase> cases = with_each_on_its_own({
      {"uniform", 1, 0, false, {}},
      {"grid", 1, 0, true, {}},
      {"tiny", 1e-30f, 0, false, {}},
      {"huge", 1e30f, 0, false, {}},
      {"shifted", 1, 1e6f, false, {}},
      {"grid in one place", 1, 0, true, {sheared}},
      {"grid in many places", 1, 0, true, {Affine{}, sheared, mirrored, sheared}},
      {"uniform in many places", 1, 0, false, {mirrored, Affine{}, sheared}},
      {"grid in one place many times", 1, 0, true, {Affine{}, Affine{}, Affine{}}},
      {"uniform beside a speck", 1, 0, false, {sheared, speck, mirrored}},
  });
  expect_together_as_alone(cases, 0.25, [](const SceneCase& c, std::mt19937_64&) {
    return make_rows(c, test::random_cases<std::size_t>(33), 150);
  });
}

/// So near each other that the widest packets pay.
TEST(Kernel, answers_rays_side_by_side_together_as_each_alone) {
  const Affine sheared = affine({1, 0.5, 0, 0, 0, 1, 0.25, 0, 0, 0, 0.5, 0});
  const std::vector<SceneCase> cases{
      {"uniform", 1, 0, false, {}},    {"grid", 1, 0, true, {}},
      {"tiny", 1e-30f, 0, false, {}},  {"huge", 1e30f, 0, false, {}},
      {"shifted", 1, 1e6f, false, {}}, {"grid in one place", 1, 0, true, {sheared}}};
  expect_together_as_alone(cases, 0.5, [](const SceneCase& c, std::mt19937_64&) {
    return make_rows(c, test::random_cases<std::size_t>(23), 330, 1024);
  });
}

TEST(Kernel, answers_scattered_rays_together_as_each_alone) {
  const Affine sheared = affine({1, 0.5, 0, 0, 0, 1, 0.25, 0, 0, 0, 0.5, 0});
  const std::vector<SceneCase> cases{
      {"uniform", 1, 0, false, {}},    {"grid", 1, 0, true, {}},
      {"tiny", 1e-30f, 0, false, {}},  {"huge", 1e30f, 0, false, {}},
      {"shifted", 1, 1e6f, false, {}}, {"grid in one place", 1, 0, true, {sheared}}};
  expect_together_as_alone(cases, 0.25, [](const SceneCase& c, std::mt19937_64& random) {
    return make_scattered_rays(c, 5000, random);
  });
}

/// The mesh as it is, once.
Result<std::shared_ptr<const Scene>> scene_of(std::shared_ptr<const Mesh> mesh) {
  SceneDescription description;
  description.meshes.push_back(std::move(mesh));
  description.nodes.push_back({});
  description.instances.push_back({});
  return Scene::build(std::move(description));
}

TEST(Kernel, details_that_underflow_are_not_taken_for_zero) {
  // The weight of corner 1 is y, and every product on the way to it underflows.
  auto mesh = std::make_shared<Mesh>();
  mesh->positions = {{0.25f, 1, 0}, {0.25f, 1.25f, 0}, {0.25f, 1, 0.25f},
                     {2, 1, 0},     {2, 1.25f, 0},     {2, 1, 0.25f}};
  mesh->indices = {0, 1, 2, 3, 4, 5};
  mesh->primitives.push_back({0, 2, 0, 0xffffffffu});
  const auto scene = scene_of(mesh);
  ASSERT_TRUE(scene.ok());
  RayBatch rays;
  rays.push_back({{0, 1, 0.0625}, {0.125, 0x1p-1074, 0}, 0, kInf});
  rays.push_back({{1.5, 1, 0.0625}, {0.25, 3 * 0x1p-1074, 0}, 0, kInf});
  HitBatch hits;
  hits.resize(rays.size());
  for (const Kernel& kernel : supported_kernels()) {
    TraceCounts counts;
    kernel.closest(**scene, rays, 0, rays.size(), hits, counts);
    std::vector<HitDetail> details(rays.size());
    kernel.details(**scene, rays, 0, rays.size(), hits, details.data(), counts);
    EXPECT_EQ(details[0].u, 0x1p-1071) << kernel.name;
    EXPECT_EQ(details[1].u, hit_detail(**scene, rays[1], hits.id(1)).u) << kernel.name;
  }
}

TEST(Kernel, rounds_normals_correctly_whose_components_are_very_small) {
  // One corner for each power of two by which a component of the normal is smaller than the others;
  // the last products underflow.
  auto mesh = std::make_shared<Mesh>();
  mesh->positions = {{0, 0, 0}, {1, 0, 0.7f}, {0.3f, 1, 0.1f}};
  mesh->indices = {0, 1, 2};
  mesh->primitives.push_back({0, 1, 0, 0xffffffffu});
  for (const int power : {-20, -100, -300, -350, -600, -700, -1000, -1060}) {
    SceneDescription description;
    description.meshes.push_back(mesh);
    description.nodes.push_back({});
    description.instances.push_back({});
    description.instances[0].world_from_mesh.m[2][2] = std::ldexp(1.0, power);
    description.instances[0].world_from_mesh.m[0][2] = 1.0 / 3;
    const auto scene = Scene::build(std::move(description));
    ASSERT_TRUE(scene.ok());
    HitBatch hits;
    hits.resize(3);
    hits.instance.assign({0, 0, 0});
    hits.triangle.assign({0, 0, 0});
    for (const Kernel& kernel : supported_kernels()) {
      std::vector<Vec3d> normals(hits.size());
      kernel.normals(**scene, 0, hits.size(), hits, normals.data());
      for (const Vec3d& normal : normals)
        EXPECT_EQ(normal, exact_normal((*scene)->world_triangle({0, 0}))) << kernel.name << power;
    }
  }
}

TEST(Kernel, lets_no_box_exclude_a_ray_along_an_axis_that_its_direction_lacks) {
  // The origin is in the face of a box far away: 0 * the inverse of 0 must not become a number.
  constexpr float kUnit = 0x1p25f;
  auto mesh = std::make_shared<Mesh>();
  for (const Vec3f& p :
       {Vec3f{-4, -2, -2}, {-6, -3, -3}, {3, 0, 3},    {3, 0, 3},    {-4, -2, -2}, {-6, -3, -3},
        {-4, -2, -2},      {-2, 1, -3},  {2, 2, 0},    {-6, -3, -3}, {-4, -2, -2}, {0, 0, 2},
        {-6, -3, -3},      {-2, 1, -3},  {3, 0, 3},    {9, 3, -2},   {-1, 0, 3},   {3, -3, 2},
        {-6, -3, -3},      {2, 2, 0},    {-4, -2, -2}, {3, -3, 2},   {9, 3, -2},   {-1, -4, 3},
        {-2, 1, -3},       {2, 2, 0},    {-6, -3, -3}}) {
    mesh->indices.own().push_back(static_cast<std::uint32_t>(mesh->positions.size()));
    mesh->positions.own().push_back({p.x * kUnit, p.y * kUnit, p.z * kUnit});
  }
  mesh->primitives.push_back({0, 9, 0, 0xffffffffu});
  const auto scene = scene_of(mesh);
  ASSERT_TRUE(scene.ok());
  const SceneView view(**scene);
  for (const double zero : {0.0, -0.0}) {
    RayBatch rays;
    const double u = static_cast<double>(kUnit);
    for (int i = 0; i < 70; ++i) {
      Ray ray;
      ray.origin = {16.5 * u, 16.5 * u, 0};
      ray.direction = {-8 * u, -8 * u, zero};
      rays.push_back(ray);
    }
    for (const Kernel& kernel : supported_kernels()) {
      for (const std::size_t count : {std::size_t{1}, std::size_t{2}, rays.size()}) {
        HitBatch hits;
        hits.resize(rays.size());
        TraceCounts counts;
        kernel.closest(view, rays, 0, count, hits, counts);
        for (std::size_t i = 0; i < count; ++i) {
          EXPECT_EQ(hits.t[i], 1.8125) << kernel.name << ", " << count << " rays";
          EXPECT_EQ(hits.triangle[i], 2u) << kernel.name << ", " << count << " rays";
        }
      }
    }
  }
}

TEST(Kernel, visits_no_more_for_a_ray_from_very_far_away) {
  std::mt19937_64 random(9);
  const auto scene = make_scene({"uniform", 1, 0, false, {}}, random);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const double distance : {1e4, 1e8, 1e12}) {
    RayBatch near, far;
    for (int i = 0; i < 2000; ++i) {
      const Vec3d target{uniform(random), uniform(random), uniform(random)};
      const Vec3d d{uniform(random), uniform(random), uniform(random)};
      near.push_back({{target.x - 3 * d.x, target.y - 3 * d.y, target.z - 3 * d.z}, d});
      far.push_back(
          {{target.x - distance * d.x, target.y - distance * d.y, target.z - distance * d.z}, d});
    }
    for (const Kernel& kernel : supported_kernels()) {
      HitBatch hits;
      hits.resize(near.size());
      TraceCounts from_near, from_far;
      kernel.closest(*scene, near, 0, near.size(), hits, from_near);
      kernel.closest(*scene, far, 0, far.size(), hits, from_far);
      EXPECT_LE(from_far.nodes, 4 * from_near.nodes) << kernel.name << " from " << distance;
      EXPECT_LE(from_far.blocks, 4 * from_near.blocks) << kernel.name << " from " << distance;
      std::printf("%-9s from %g: nodes %.2f times, blocks %.2f times those from nearby\n",
                  std::string(kernel.name).c_str(), distance,
                  static_cast<double>(from_far.nodes) / static_cast<double>(from_near.nodes),
                  static_cast<double>(from_far.blocks) / static_cast<double>(from_near.blocks));
    }
  }
}

TEST(Kernel, gives_up_in_the_middle_of_a_ray_when_its_time_is_over) {
  // Four thousand triangles one behind the other.
  constexpr std::uint32_t kCount = 4000;
  auto mesh = std::make_shared<Mesh>();
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const auto z = static_cast<float>(i);
    for (const Vec3f& corner : {Vec3f{0, 0, z}, Vec3f{1, 0, z}, Vec3f{0, 1, z}}) {
      mesh->positions.own().push_back(corner);
    }
    for (std::uint32_t k = 0; k < 3; ++k) mesh->indices.own().push_back(3 * i + k);
  }
  mesh->primitives.push_back({0, kCount, 0, 0xffffffffu});
  const auto scene = scene_of(mesh);
  ASSERT_TRUE(scene.ok());
  RayBatch rays;
  for (int i = 0; i < 300; ++i) rays.push_back({{0.25, 0.25, -1}, {0, 0, 1}});
  CancelFlag over;
  const Deadline deadline{.flag = &over};
  for (const bool is_over : {false, true}) {
    if (is_over) over.cancel();
    for (const Kernel& kernel : supported_kernels()) {
      TraceCounts one, many;
      one.deadline = many.deadline = &deadline;
      std::uint64_t total = 0;
      kernel.all(**scene, rays, 0, 1, {Crossings::kEvery, 0, &total, nullptr}, one);
      EXPECT_EQ(one.stopped, is_over) << kernel.name;
      EXPECT_EQ(total == kCount, !is_over) << kernel.name;
      HitBatch hits;
      hits.resize(rays.size());
      kernel.closest(**scene, rays, 0, rays.size(), hits, many);
      EXPECT_EQ(hits.t == Column<double>(rays.size(), 1), !many.stopped) << kernel.name;
    }
  }
}

}  // namespace
}  // namespace sightline
