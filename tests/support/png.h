#pragma once
/// Images for tests.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sightline::test {

/// A grey PNG of 8 bits, noise from the seed, stored without compression.
std::vector<std::byte> noise_png(std::uint32_t width, std::uint32_t height, std::uint32_t seed);

}  // namespace sightline::test
