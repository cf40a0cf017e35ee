// Hits that are filtered by side, node and material, against rational arithmetic.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/infinity.h"
#include "core/run/engine.h"
#include "core/run/resolved_filter.h"
#include "tests/oracle/random.h"
#include "tests/oracle/scene_oracle.h"
#include "tests/oracle/world_triangles.h"
#include "tests/support/random_cases.h"

namespace sightline {
namespace {

constexpr std::uint64_t kFilterSeed = 62;

/// Random triangles on a small grid, so that many rays meet edges, lie in planes or find ties;
/// three primitives with the materials "glass" (double-sided), "steel" and none.
std::shared_ptr<const Mesh> grid_mesh(oracle::Random& random) {
  auto mesh = std::make_shared<Mesh>();
  for (int i = 0; i < 40; ++i) {
    const auto x = [&] { return static_cast<float>(random.integer(-3, 3)); };
    mesh->positions.own().push_back({x(), x(), x()});
  }
  for (int i = 0; i < 3 * 60; ++i)
    mesh->indices.own().push_back(static_cast<std::uint32_t>(random.index(40)));
  mesh->primitives = {{0, 20, 0, 0}, {20, 20, 1, 1}, {40, 20, 2, kNone}};
  return mesh;
}

/// root (10) has left (11) and right (12); right has leaf (13).
std::shared_ptr<const Scene> sample(oracle::Random& random, Joining joining) {
  SceneDescription description;
  description.meshes = {grid_mesh(random), grid_mesh(random)};
  description.nodes = {
      {"root", 10, kNone, {}}, {"left", 11, 0, {}}, {"right", 12, 0, {}}, {"leaf", 13, 2, {}}};
  description.materials = {{"glass", true}, {"steel", false}};
  Affine moved, mirrored;
  moved.m[0][3] = 2;
  mirrored.m[2][2] = -1;
  description.instances = {{0, 1, {}}, {1, 2, moved}, {0, 3, mirrored}};
  return *Scene::build(std::move(description), TreeQuality::kHigh, joining);
}

/// What a filter keeps, said once more: by file node and material of the hit.
struct Expectation {
  const char* name;
  HitFilter filter;
  bool (*keeps)(std::uint32_t file_node, std::uint32_t material);
};

std::vector<Expectation> expectations() {
  const auto always = [](std::uint32_t, std::uint32_t) { return true; };
  using Names = std::vector<std::string>;
  using Nodes = std::vector<std::uint32_t>;
  return {
      {"back", {Culling::kBack, {}, {}}, always},
      {"front", {Culling::kFront, {}, {}}, always},
      {"material", {Culling::kMaterial, {}, {}}, always},
      {"include a node",
       {Culling::kNothing, TriangleChoice{Nodes{12}, {}, {}}, {}},
       [](std::uint32_t node, std::uint32_t) { return node == 12 || node == 13; }},
      {"exclude a glob",
       {Culling::kNothing, {}, TriangleChoice{{}, Names{"l*"}, {}}},
       [](std::uint32_t node, std::uint32_t) { return node == 12; }},
      {"exclude a material",
       {Culling::kBack, {}, TriangleChoice{{}, {}, Names{"gl?ss"}}},
       [](std::uint32_t, std::uint32_t material) { return material != 0; }},
      {"include and exclude",
       {Culling::kNothing, TriangleChoice{Nodes{10}, {}, Names{"*"}},
        TriangleChoice{Nodes{11}, {}, Names{"steel"}}},
       [](std::uint32_t node, std::uint32_t material) {
         return material != kNone && !(node == 11 && material == 1);
       }},
      {"nothing",
       {Culling::kNothing, TriangleChoice{{}, Names{}, {}}, {}},
       [](std::uint32_t, std::uint32_t) { return false; }},
  };
}

RayBatch grid_rays(oracle::Random& random, std::size_t count) {
  RayBatch rays;
  while (rays.size() < count) {
    const bool is_grid = random.chance(0.7);
    const auto x = [&] {
      return is_grid ? static_cast<double>(random.integer(-4, 4)) : random.between(-4, 4);
    };
    Ray ray{{x(), x(), x()}, {x(), x(), x()}};
    if (random.chance(0.3)) ray.tmin = -1;
    if (random.chance(0.3)) ray.tmax = 1;
    if (ray.direction.x == 0 && ray.direction.y == 0 && ray.direction.z == 0) continue;
    rays.push_back(ray);
  }
  return rays;
}

class FilteredTruth {
 public:
  explicit FilteredTruth(const Scene& scene)
      : scene_(scene), world_(scene), oracle_(world_.triangles) {}

  using Kept = std::vector<std::pair<TriangleId, double>>;
  Kept all(const Ray& ray, const Expectation& expected) const {
    Kept kept;
    for (const oracle::OracleHit& hit : oracle_.all(ray)) {
      const TriangleId id = world_.id(hit.triangle);
      const SceneDescription& description = scene_.description();
      const Instance& instance = description.instances[id.instance];
      const std::uint32_t material =
          description.meshes[instance.mesh]->primitives[id.triangle / 20].material;
      if (!expected.keeps(description.nodes[instance.node].file_node, material)) continue;
      const oracle::ExactDetail detail =
          oracle::exact_detail(ray, world_.triangles[hit.triangle], hit.t);
      const mpq_class side = detail.normal[0] * ray.direction.x +
                             detail.normal[1] * ray.direction.y +
                             detail.normal[2] * ray.direction.z;
      const Culling culling = expected.filter.culling;
      const bool culls =
          culling != Culling::kNothing && !(culling == Culling::kMaterial && material == 0);
      if (culls && !(culling == Culling::kFront ? side > 0 : side < 0)) continue;
      kept.emplace_back(id, hit.t_rounded);
    }
    return kept;
  }

 private:
  const Scene& scene_;
  oracle::WorldTriangles world_;
  oracle::SceneOracle oracle_;
};

TEST(Filter, gives_what_rational_arithmetic_keeps_on_every_kernel) {
  std::printf("seed %llu\n", static_cast<unsigned long long>(kFilterSeed));
  oracle::Random random(kFilterSeed);
  std::size_t kept_hits = 0, hidden = 0;
  for (const Joining joining : {Joining::kMeasured, Joining::kNever}) {
    const auto scene = sample(random, joining);
    const FilteredTruth truth(*scene);
    const RayBatch rays = grid_rays(random, test::random_cases<std::size_t>(600));
    for (const Expectation& expected : expectations()) {
      const auto kept = resolve_filter(*scene, expected.filter, Deadline::never(), {});
      ASSERT_TRUE(kept.ok());
      std::vector<FilteredTruth::Kept> truths;
      for (std::size_t i = 0; i < rays.size(); ++i) truths.push_back(truth.all(rays[i], expected));
      for (const std::string& kernel : Engine::kernels()) {
        const auto engine = *Engine::create({2, kernel});
        const RayOptions options{&*kept, nullptr};
        HitBatch closest, unfiltered;
        Column<std::uint8_t> any;
        Column<std::uint64_t> counts, totals;
        HitLists lists;
        const Deadline never = Deadline::never();
        ASSERT_TRUE(engine->closest(*scene, rays, never, closest, options));
        ASSERT_TRUE(engine->closest(*scene, rays, never, unfiltered));
        ASSERT_TRUE(engine->any(*scene, rays, never, any, options));
        ASSERT_TRUE(engine->count(*scene, rays, Crossings::kEvery, never, counts, options));
        ASSERT_TRUE(engine->all(*scene, rays, {Crossings::kEvery, 100, 1000000}, never, lists,
                                totals, options));
        for (std::size_t i = 0; i < rays.size(); ++i) {
          SCOPED_TRACE(std::string(expected.name) + ", " + kernel + ", ray " + std::to_string(i));
          const auto& exact = truths[i];
          ASSERT_EQ(counts[i], exact.size());
          ASSERT_EQ(totals[i], exact.size());
          ASSERT_EQ(any[i] != 0, !exact.empty());
          ASSERT_EQ(closest.t[i], exact.empty() ? kInf : exact[0].second);
          ASSERT_EQ(closest.id(i), exact.empty() ? TriangleId() : exact[0].first);
          for (std::size_t k = 0; k < exact.size(); ++k) {
            ASSERT_EQ(lists.hits.id(lists.first[i] + k), exact[k].first);
            ASSERT_EQ(lists.hits.t[lists.first[i] + k], exact[k].second);
          }
          kept_hits += exact.size();
          hidden += !exact.empty() && closest.id(i) != unfiltered.id(i) ? 1u : 0u;
        }
      }
    }
  }
  std::printf("hits kept %zu, rays with a nearer hit that does not count %zu\n", kept_hits, hidden);
  EXPECT_GT(hidden, test::random_cases(1000u));
}

TEST(Filter, names_a_node_that_the_scene_does_not_have) {
  oracle::Random random(kFilterSeed);
  const auto scene = sample(random, Joining::kMeasured);
  HitFilter filter;
  filter.exclude = TriangleChoice{std::vector<std::uint32_t>{11, 7}, {}, {}};
  const auto kept = resolve_filter(*scene, filter, Deadline::never(), {});
  ASSERT_FALSE(kept.ok());
  EXPECT_EQ(kept.error().code, "FILTER_NODE_UNKNOWN");
  EXPECT_EQ(kept.error().pointer, "/exclude/nodes/1");
}

TEST(Filter, patterns_match_as_shells_do) {
  for (const auto& [pattern, text, matches] : {std::tuple{"", "", true},
                                               {"", "a", false},
                                               {"*", "", true},
                                               {"tree*", "tree 17", true},
                                               {"tree*", "a tree", false},
                                               {"*tree*", "a tree 7", true},
                                               {"a?c", "abc", true},
                                               {"a?c", "ac", false},
                                               {"?", "\xc3\xa4", true},
                                               {"??", "\xc3\xa4", false},
                                               {"a*b*c", "a b b c", true},
                                               {"a*b*c", "a c b", false},
                                               {"*a", "aaaa", true},
                                               {"[a]", "a", false},
                                               {"**", "xyz", true}}) {
    const Deadline never = Deadline::never();
    DeadlineWatch watch(never);
    EXPECT_EQ(glob_matches(pattern, text, watch), matches) << pattern << " " << text;
  }
}

/// One triangle at each of these nodes.
std::shared_ptr<const Scene> named(const std::vector<std::string>& names) {
  auto mesh = std::make_shared<Mesh>();
  mesh->positions.own() = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh->indices.own() = {0, 1, 2};
  mesh->primitives = {{0, 1, 0, kNone}};
  SceneDescription description;
  description.meshes = {std::move(mesh)};
  for (std::uint32_t i = 0; i < names.size(); ++i) {
    description.nodes.push_back({names[i], i, kNone, {}});
    description.instances.push_back({0, i, {}});
  }
  return *Scene::build(std::move(description));
}

TEST(Filter, chooses_the_same_names_however_often_they_come) {
  // More different names than are remembered, some of them again and again.
  std::vector<std::string> names;
  names.reserve(80000);
  for (int i = 0; i < 80000; ++i)
    names.push_back("n" + std::to_string(i % 3 == 0 ? i % 100 : i * 7));
  const auto scene = named(names);
  HitFilter filter;
  filter.include = TriangleChoice{{}, std::vector<std::string>{"*7?", "n3*1", "n0"}, {}};
  const auto kept = resolve_filter(*scene, filter, Deadline::never(), {});
  ASSERT_TRUE(kept.ok());
  const Deadline never = Deadline::never();
  DeadlineWatch watch(never);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool matches =
        std::any_of(filter.include->names->begin(), filter.include->names->end(),
                    [&](const auto& pattern) { return glob_matches(pattern, names[i], watch); });
    ASSERT_EQ(kept->sides[kept->first[i]] != 0, matches) << names[i];
  }
}

std::vector<std::string> pointers(const SelectionWarnings& warnings) {
  std::vector<std::string> result;
  for (const SelectionWarning& warning : warnings) result.push_back(warning.pointer);
  return result;
}

TEST(Filter, warns_of_what_matches_nothing_or_refuses_it) {
  const auto scene = named({"house", "house", "door"});
  using Patterns = std::vector<std::string>;
  const auto check = [&](const HitFilter& filter, const std::vector<std::string>& expected) {
    SelectionWarnings warnings;
    const auto kept = resolve_for_rays(*scene, filter, {}, Deadline::never(), {}, &warnings);
    ASSERT_TRUE(kept.ok());
    EXPECT_EQ(pointers(warnings), expected);
    const auto strict = resolve_for_rays(*scene, filter, {}, Deadline::never(), {});
    ASSERT_EQ(strict.ok(), expected.empty());
    if (expected.empty()) return;
    EXPECT_EQ(strict.error().code, kSelectionEmpty);
    EXPECT_EQ(strict.error().pointer, expected[0]);
    EXPECT_EQ(strict.error().message, warnings[0].message);
  };
  HitFilter filter;
  // What an earlier pattern has matched is held against the later ones too.
  filter.include = TriangleChoice{{}, Patterns{"*", "house", "h*", "door"}, {}};
  check(filter, {});
  filter.include->names = Patterns{"*", "hous", "door", "windows"};
  filter.exclude = TriangleChoice{{}, {}, Patterns{"glass"}};
  check(filter, {"/include/names/1", "/include/names/3", "/exclude/materials/0"});
  // An empty list chooses nothing, as it says.
  filter.include->names = Patterns{};
  filter.exclude = {};
  check(filter, {});
}

TEST(Filter, holds_patterns_against_what_lies_below_a_chosen_node) {
  SceneDescription description = named({"house", "door", "knob"})->description();
  description.nodes[1].parent = 0;
  description.nodes[2].parent = 1;
  const auto scene = *Scene::build(std::move(description));
  HitFilter filter;
  filter.include = TriangleChoice{{}, std::vector<std::string>{"house", "knob"}, {}};
  EXPECT_TRUE(resolve_filter(*scene, filter, Deadline::never(), {}).ok());
  filter.include->names = {"house", "knobs"};
  EXPECT_EQ(resolve_filter(*scene, filter, Deadline::never(), {}).error().pointer,
            "/include/names/1");
}

TEST(Filter, warns_of_a_choice_without_triangles) {
  SceneDescription description = named({"house", "door"})->description();
  description.nodes.push_back({"camera", 2, kNone, {}});
  description.materials.resize(1);
  description.materials[0].name = "glass";
  const auto scene = *Scene::build(std::move(description));
  using Patterns = std::vector<std::string>;
  for (const TriangleChoice& choice : {TriangleChoice{{}, Patterns{"camera"}, {}},
                                       TriangleChoice{std::vector<std::uint32_t>{2}, {}, {}},
                                       TriangleChoice{{}, Patterns{"house"}, Patterns{"glass"}}}) {
    SelectionWarnings warnings;
    ASSERT_TRUE(chosen_sides(*scene, choice, "a", Deadline::never(), {}, &warnings).ok());
    EXPECT_EQ(pointers(warnings), std::vector<std::string>{"/a"});
    const auto strict = chosen_sides(*scene, choice, "a", Deadline::never(), {});
    ASSERT_FALSE(strict.ok());
    EXPECT_EQ(strict.error().code, kSelectionEmpty);
  }
}

TEST(Filter, ends_with_its_deadline_and_with_its_caller) {
  // A long name that nearly matches: without an end some minutes.
  const auto scene = named({std::string(std::size_t{8} << 20, 'a')});
  HitFilter filter;
  filter.include = TriangleChoice{
      {},
      std::vector<std::string>(64, "*" + std::string(200, 'a') + "?" + std::string(50, 'b')),
      {}};
  CancelFlag gone;
  gone.cancel();
  const std::vector<std::uint32_t> masks{1, 2};
  for (const auto& [deadline, code] :
       {std::pair{Deadline::in(std::chrono::milliseconds(20)), "DEADLINE"},
        {Deadline::in(std::chrono::hours(1), &gone), "CANCELLED"}}) {
    const auto kept = resolve_for_rays(*scene, filter, masks, deadline, {});
    ASSERT_FALSE(kept.ok());
    EXPECT_EQ(kept.error().code, code);
    const auto chosen = chosen_sides(*scene, *filter.include, "a", deadline, {});
    ASSERT_FALSE(chosen.ok());
    EXPECT_EQ(chosen.error().code, code);
  }
}

TEST(Filter, asks_for_the_memory_that_it_takes) {
  const auto scene = named(std::vector<std::string>(1000, "n"));
  std::uint64_t asked = 0;
  const ReserveBytes counts = [&](std::uint64_t bytes) {
    asked += bytes;
    return success();
  };
  const ReserveBytes refuses = [](std::uint64_t) {
    return Error{ErrorKind::kTooLarge, "REQUEST_TOO_LARGE", "", ""};
  };
  // What keeps everything takes nothing.
  ASSERT_TRUE(resolve_for_rays(*scene, {}, {}, Deadline::never(), refuses).ok());
  HitFilter back;
  back.culling = Culling::kBack;
  const auto kept = resolve_for_rays(*scene, back, {}, Deadline::never(), counts);
  ASSERT_TRUE(kept.ok() && kept->has_value());
  EXPECT_GE(asked, (*kept)->first.capacity() * sizeof((*kept)->first[0]) +
                       (*kept)->sides.capacity() + (*kept)->masks.capacity() * 4);
  EXPECT_EQ(resolve_for_rays(*scene, back, {}, Deadline::never(), refuses).error().code,
            "REQUEST_TOO_LARGE");
  const TriangleChoice all{{}, std::vector<std::string>{"*"}, {}};
  EXPECT_EQ(chosen_sides(*scene, all, "a", Deadline::never(), refuses).error().code,
            "REQUEST_TOO_LARGE");
}

}  // namespace
}  // namespace sightline
