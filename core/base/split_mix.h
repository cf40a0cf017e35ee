#pragma once
/// Pseudo-random numbers from a seed, equal on every machine: only integer arithmetic and one exact
/// product.

#include <cstdint>

namespace sightline {

/// One step of splitmix64 [Steele2014]: a bijective mixing of 64 bits.
constexpr std::uint64_t scramble(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// The splitmix64 generator of a seed. Equal seeds give equal numbers. Not cryptographic.
class SplitMix {
 public:
  constexpr explicit SplitMix(std::uint64_t seed) : state_(seed) {}

  /// The next 64 bits.
  constexpr std::uint64_t bits() {
    const std::uint64_t value = scramble(state_);
    state_ += 0x9e3779b97f4a7c15u;
    return value;
  }
  /// The next number, uniform in [0, 1), a multiple of 2^-53.
  constexpr double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }

 private:
  std::uint64_t state_;
};

/// The numbers of one of many streams of a seed.
constexpr SplitMix stream_of(std::uint64_t seed, std::uint64_t stream) {
  return SplitMix(SplitMix(seed).bits() ^ (stream * 0x9e3779b97f4a7c15u));
}

}  // namespace sightline
