#pragma once
/// A hash that tests write down, so that "the same bytes everywhere" can be checked anywhere.

#include <cstddef>
#include <cstdint>
#include <span>

namespace sightline::test {

/// FNV-1a, 64 bits.
std::uint64_t golden_hash(std::span<const std::byte> bytes);

}  // namespace sightline::test
