/// The short version of sightline_stress_boxes: every family, a fixed seed.

#include <gtest/gtest.h>

#include "tests/stress/triangle_box_cases.h"

namespace sightline::stress {
namespace {

constexpr std::uint64_t kSeed = 20250302;
constexpr int kRounds = 600;

TEST(TriangleBoxStress, agrees_with_the_oracle_in_every_family) {
  int touching = 0, met = 0, judged = 0, filtered = 0;
  for (const TriangleBoxFamily& family : triangle_box_families()) {
    oracle::Random random(kSeed);
    int faults = 0;
    for (int i = 0; i < kRounds * family.weight && faults < 3; ++i) {
      const TriangleBoxCase test = family.make(random);
      const TriangleBoxVerdict verdict = judge(test);
      ++judged;
      met += verdict.meets ? 1 : 0;
      touching += verdict.touching ? 1 : 0;
      filtered += verdict.filtered ? 1 : 0;
      if (verdict.fault.empty()) continue;
      ++faults;
      ADD_FAILURE() << family.name << " seed " << kSeed << " case " << i << ": " << verdict.fault
                    << "\n  " << describe(test);
    }
  }
  std::printf("seed %llu: %d pairs, %d meet, %d touch exactly, %d decided by the filter\n",
              static_cast<unsigned long long>(kSeed), judged, met, touching, filtered);
  EXPECT_GT(touching, judged / 3);
}

}  // namespace
}  // namespace sightline::stress
