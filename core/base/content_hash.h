#pragma once
/// A fast 64-bit hash of bytes. It detects equal contents and accidental damage. It is not
/// cryptographic: an attacker can forge a content with a given hash.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace sightline {

/// Incremental hash: any number of add(), then value(). Four lanes of multiply and rotate, as in
/// xxHash64 (same rounds, other final mixing). The parts are not joined: the split into add() calls
/// changes the value unless each part but the last is a multiple of 32 bytes.
class ContentHash {
 public:
  /// Adds bytes.
  void add(std::span<const std::byte> bytes) {
    length_ += bytes.size();
    const std::byte* at = bytes.data();
    // Computed without the loop: GCC 14 would warn that the last copy may be longer than `last`.
    const std::size_t rest = bytes.size() % 32;
    const std::byte* const end = at + (bytes.size() - rest);
    // In registers: storing the lanes at each turn would take twice the time.
    std::uint64_t a = lane_[0], b = lane_[1], c = lane_[2], d = lane_[3];
    for (; at != end; at += 32) {
      a = mix(a, word(at, 0));
      b = mix(b, word(at, 1));
      c = mix(c, word(at, 2));
      d = mix(d, word(at, 3));
    }
    lane_[0] = a, lane_[1] = b, lane_[2] = c, lane_[3] = d;
    std::byte last[32] = {};
    if (rest > 0) {
      std::memcpy(last, end, rest);
      for (std::size_t lane = 0; lane < 4; ++lane) lane_[lane] = mix(lane_[lane], word(last, lane));
    }
  }
  /// The hash of all bytes added so far.
  std::uint64_t value() const {
    std::uint64_t hash = length_ * kB;
    for (const std::uint64_t lane : lane_) hash = (hash ^ mix(0, lane)) * kA + kB;
    hash = (hash ^ hash >> 33) * kB;
    hash = (hash ^ hash >> 29) * kA;
    return hash ^ hash >> 32;
  }

 private:
  static constexpr std::uint64_t kA = 0x9e3779b185ebca87ull;
  static constexpr std::uint64_t kB = 0xc2b2ae3d27d4eb4full;
  static std::uint64_t mix(std::uint64_t lane, std::uint64_t word) {
    return std::rotl(lane + word * kB, 31) * kA;
  }
  static std::uint64_t word(const std::byte* at, std::size_t lane) {
    std::uint64_t word = 0;
    std::memcpy(&word, at + 8 * lane, sizeof word);
    return word;
  }
  std::uint64_t lane_[4] = {kA + kB, kB, 0, 0 - kA};
  std::uint64_t length_ = 0;
};

/// The hash of one block of bytes.
inline std::uint64_t hash_of(std::span<const std::byte> bytes) {
  ContentHash hash;
  hash.add(bytes);
  return hash.value();
}

/// The size of a piece of hash_in_pieces, in bytes.
inline constexpr std::size_t kHashPiece = 1u << 22;

/// The hash of the hashes of all pieces of kHashPiece bytes, computed in parallel. It differs from
/// hash_of of the whole. Throws std::bad_alloc.
std::uint64_t hash_in_pieces(std::span<const std::byte> bytes);

}  // namespace sightline

// Tests: tests/unit/scene/scene_plan_test.cpp
