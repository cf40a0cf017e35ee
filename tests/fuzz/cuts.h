#pragma once
/// The places at which a stream is cut into pieces.

#include <algorithm>
#include <cstddef>

namespace sightline::fuzz {

/// Lengths of the pieces that a stream comes in: all at once, byte by byte, or as the seed says.
class Cuts {
 public:
  explicit Cuts(unsigned seed) : state_(seed) {}
  std::size_t next(std::size_t left) {
    if (state_ == 0 || left < 2) return left;
    if (state_ == 1) return 1;
    state_ = state_ * 1664525u + 1013904223u;
    return std::min<std::size_t>(left, 1 + (state_ >> 24) % 37);
  }

 private:
  unsigned state_;
};

}  // namespace sightline::fuzz
