#pragma once
/// kCompress: a table that moves selected lanes of eight to the front, for instruction sets without
/// a compress instruction.

#include <array>
#include <cstddef>
#include <cstdint>

namespace sightline {

/// kCompress[m][i] is the number of the i-th set bit of m, for i below the number of set bits; it
/// is 0 for larger i. 2 KiB with static storage: g++ 12 would copy a local constant of an inlined
/// function to the stack at each call (docs/decisions/0022).
using CompressTable = std::array<std::array<std::uint8_t, 8>, 256>;

/// Computes the table.
constexpr CompressTable make_compress_table() {
  CompressTable table{};
  for (std::size_t mask = 0; mask < table.size(); ++mask) {
    std::size_t size = 0;
    for (std::uint8_t bit = 0; bit < 8; ++bit) {
      if ((mask >> bit & 1u) != 0) table[mask][size++] = bit;
    }
  }
  return table;
}

alignas(64) inline constexpr CompressTable kCompress = make_compress_table();

}  // namespace sightline

// Tests: tests/unit/trace/kernel_test.cpp
