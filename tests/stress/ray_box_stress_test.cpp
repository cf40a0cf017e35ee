/// The short version of sightline_stress_boxes: every family, a fixed seed.

#include <gtest/gtest.h>

#include "tests/stress/ray_box_cases.h"

namespace sightline::stress {
namespace {

constexpr std::uint64_t kSeed = 20250301;
constexpr int kRounds = 2000;

TEST(RayBoxStress, agrees_with_the_oracle_in_every_family) {
  int touching = 0, hits = 0, judged = 0;
  for (const RayBoxFamily& family : ray_box_families()) {
    oracle::Random random(kSeed);
    int faults = 0;
    for (int i = 0; i < kRounds * family.weight && faults < 3; ++i) {
      const RayBoxCase test = family.make(random);
      const RayBoxVerdict verdict = judge(test);
      ++judged;
      hits += verdict.hit ? 1 : 0;
      touching += verdict.touching ? 1 : 0;
      if (verdict.fault.empty()) continue;
      ++faults;
      ADD_FAILURE() << family.name << " seed " << kSeed << " case " << i << ": " << verdict.fault
                    << "\n  " << describe(test);
    }
  }
  std::printf("seed %llu: %d pairs, %d hits, %d touching exactly\n",
              static_cast<unsigned long long>(kSeed), judged, hits, touching);
  EXPECT_GT(touching, judged / 3);
}

TEST(RayBoxStress, batches_of_every_kernel_answer_as_single_pairs) {
  for (const RayBoxFamily& family : ray_box_families()) {
    oracle::Random random(kSeed + 1);
    std::vector<RayBoxCase> cases;
    cases.reserve(kRounds);
    for (int i = 0; i < kRounds; ++i) cases.push_back(family.make(random));
    const auto found = differing_kernels(cases);
    EXPECT_EQ(found.size(), 0u) << family.name << ": " << found.front().fault << "\n  "
                                << describe(cases[found.front().number]);
  }
}

}  // namespace
}  // namespace sightline::stress
