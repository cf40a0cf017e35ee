/// Sightline against Embree over generated scenes and every shared scene that loads. Where they
/// disagree the oracle decides; it also judges a sample of the rays on which they agree.
/// More rays per scene: CROSSCHECK_RAYS=N.

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "core/run/engine.h"
#include "tests/crosscheck/judge.h"
#include "tests/crosscheck/rays.h"
#include "tests/crosscheck/scenes.h"
#include "tests/support/data_folder.h"

namespace sightline::crosscheck {
namespace {

constexpr std::size_t kSampleEvery = 50;
constexpr std::uint64_t kSeed = 20240501;

/// Rays for each generated scene; a file gets a third of them. Twelve generated scenes alone make
/// more than a million.
std::size_t rays_per_scene() {
  if (const char* text = std::getenv("CROSSCHECK_RAYS"))
    return std::max<std::size_t>(1000, std::strtoull(text, nullptr, 10));
  return SIGHTLINE_CROSSCHECK_RAYS;
}

class Crosscheck : public testing::Test {
 protected:
  static void SetUpTestSuite() { total() = {}; }
  static void TearDownTestSuite() {
    std::printf("total: %zu scenes, %zu rays, %zu hits, %zu judged exactly\n%s", scenes(),
                total().rays, total().hits, total().judged, total().lines().c_str());
  }
  static Verdict& total() {
    static Verdict verdict;
    return verdict;
  }
  static std::size_t& scenes() {
    static std::size_t count = 0;
    return count;
  }

  static void check(const NamedScene& source, std::size_t ray_count) {
    Result<SceneDescription> description = source.load();
    if (!description) {
      std::printf("scene %s: not loaded: %s: %s\n", source.name.c_str(),
                  description.error().code.c_str(), description.error().message.c_str());
      return;
    }
    auto scene = Scene::build(std::move(description).value());
    ASSERT_TRUE(scene.ok()) << source.name << ": " << scene.error().message;
    auto engine = Engine::create({.threads = 2, .kernel = ""});
    ASSERT_TRUE(engine.ok()) << engine.error().message;

    const oracle::WorldTriangles triangles(**scene);
    const oracle::SceneOracle oracle(triangles.triangles);
    const EmbreeScene embree(triangles.triangles, false);
    const RayBatch rays = mixed_rays(triangles.triangles, ray_count, kSeed);
    RayFault fault;
    ASSERT_TRUE(check_rays(rays, fault)) << source.name << ": ray " << fault.ray << fault.code;

    Answers answers;
    ASSERT_TRUE((*engine)->closest(**scene, rays, Deadline::never(), answers.closest).ok());
    ASSERT_TRUE((*engine)->any(**scene, rays, Deadline::never(), answers.any).ok());
    ASSERT_EQ(answers.closest.size(), rays.size());
    ASSERT_EQ(answers.any.size(), rays.size());

    const Verdict verdict = judge(rays, answers, embree, oracle, triangles, kSampleEvery);
    std::printf("scene %s: %zu triangles, %zu rays, %zu hits, %zu judged exactly\n%s",
                source.name.c_str(), triangles.triangles.size(), verdict.rays, verdict.hits,
                verdict.judged, verdict.lines().c_str());
    for (const std::string& text : verdict.wrong) ADD_FAILURE() << source.name << ": " << text;
    EXPECT_EQ(verdict.sightline_wrong, 0u) << source.name;
    EXPECT_GT(verdict.hits, verdict.rays / 20) << source.name << ": the rays miss the scene";
    total().add(verdict);
    ++scenes();
  }
};

TEST_F(Crosscheck, sightline_is_never_wrong_on_generated_scenes) {
  for (const NamedScene& scene : generated_scenes()) check(scene, rays_per_scene());
}

TEST_F(Crosscheck, sightline_is_never_wrong_on_the_shared_scenes) {
  const auto folder = test::data_folder();
  if (!folder) GTEST_SKIP() << "SKIPPED: no shared scenes ($SIGHTLINE_DATA)";
  const std::size_t before = scenes();
  for (const NamedScene& scene : file_scenes(*folder / "scenes"))
    check(scene, rays_per_scene() / 3);
  EXPECT_GE(scenes() - before, 8u) << "too few of the shared scenes load";
}

}  // namespace
}  // namespace sightline::crosscheck
