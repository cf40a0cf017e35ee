#pragma once
/// Colours that distinguish nodes in pictures and point clouds.

#include <array>
#include <cstdint>

namespace sightline {

/// Red, green and blue of a node, 0 to 255. Hues follow the golden ratio, so that nodes with near
/// indices have distant hues; every third node is as bright. At least one part is 143 or more.
/// file_node  index of the node in the file
constexpr std::array<std::uint8_t, 3> node_colour(std::uint32_t file_node) {
  constexpr std::uint32_t kGolden = 0x9e3779b9u;  // 2^32 divided by the golden ratio
  // The hue as a sixth of the circle, and the position in it.
  const std::uint64_t hue = (std::uint64_t{std::uint32_t{file_node * kGolden}} * 6) >> 24;
  const auto rising = static_cast<std::uint32_t>(hue & 255u), falling = 255 - rising;
  const std::array<std::array<std::uint32_t, 3>, 6> sixths{{{255, rising, 0},
                                                            {falling, 255, 0},
                                                            {0, 255, rising},
                                                            {0, falling, 255},
                                                            {rising, 0, 255},
                                                            {255, 0, falling}}};
  const std::uint32_t light = 256 - 56 * (file_node % 3);
  std::array<std::uint8_t, 3> colour{};
  for (std::size_t k = 0; k < 3; ++k) {
    colour[k] = static_cast<std::uint8_t>(sixths[hue >> 8][k] * light >> 8);
  }
  return colour;
}

}  // namespace sightline

// Tests: tests/integration/sensors_test.py
