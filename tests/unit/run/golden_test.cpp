// The same bytes from every kernel, number of threads, order and size of batch: one hash per scene,
// written down here, so that any machine can tell.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <random>

#include "tests/unit/run/golden_answers.h"

namespace sightline {
namespace {

using test::Answers;
using test::ask;
using test::engine_of;
using test::Golden;
using test::kGolden;
using test::rays_into;
using test::scene_of;

TEST(Golden, every_kernel_and_number_of_threads_gives_the_same_bytes) {
  for (const Golden& golden : kGolden) {
    const auto scene = scene_of(golden.make());
    const RayBatch rays = rays_into(*scene);
    for (const std::string& kernel : Engine::kernels()) {
      for (const int threads : {1, 2}) {
        const std::uint64_t hash = ask(*engine_of(kernel, threads), *scene, rays).hash();
        EXPECT_EQ(hash, golden.hash)
            << golden.name << ", " << kernel << ", " << threads << " threads";
        std::printf("%-10s %-9s %d threads 0x%016llx\n", golden.name, kernel.c_str(), threads,
                    static_cast<unsigned long long>(hash));
      }
    }
  }
}

TEST(Golden, order_and_size_of_a_batch_change_no_byte) {
  for (const Golden& golden : kGolden) {
    const auto scene = scene_of(golden.make());
    const RayBatch rays = rays_into(*scene);
    const auto engine = engine_of("", 2);
    const Answers whole = ask(*engine, *scene, rays);

    std::vector<std::size_t> order(rays.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), std::mt19937_64(3));
    RayBatch shuffled;
    for (const std::size_t i : order) shuffled.push_back(rays[i]);
    const Answers other = ask(*engine, *scene, shuffled);
    for (std::size_t k = 0; k < order.size(); ++k) {
      ASSERT_EQ(other.closest.id(k), whole.closest.id(order[k])) << golden.name;
      ASSERT_EQ(std::bit_cast<std::uint64_t>(other.closest.t[k]),
                std::bit_cast<std::uint64_t>(whole.closest.t[order[k]]))
          << golden.name;
      ASSERT_EQ(other.any[k], whole.any[order[k]]) << golden.name;
      ASSERT_EQ(other.count[k], whole.count[order[k]]) << golden.name;
      ASSERT_EQ(other.crossings[k], whole.crossings[order[k]]) << golden.name;
    }

    for (std::size_t i = 0; i < rays.size(); i += 7) {
      RayBatch single;
      single.push_back(rays[i]);
      HitBatch hits;
      Column<std::uint8_t> any;
      ASSERT_TRUE(engine->closest(*scene, single, Deadline::never(), hits).ok());
      ASSERT_TRUE(engine->any(*scene, single, Deadline::never(), any).ok());
      ASSERT_EQ(hits.id(0), whole.closest.id(i)) << golden.name;
      ASSERT_EQ(std::bit_cast<std::uint64_t>(hits.t[0]),
                std::bit_cast<std::uint64_t>(whole.closest.t[i]))
          << golden.name;
      ASSERT_EQ(any[0], whole.any[i]) << golden.name;
    }
  }
}

}  // namespace
}  // namespace sightline
