#pragma once
/// Who answers beside Sightline, each as its users get it.

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tests/crosscheck/embree_scene.h"
#include "tests/oracle/scene_oracle.h"

namespace sightline::stress {

struct PeerHit {
  std::size_t triangle = 0;
  double t = 0;
};

/// Answers to closest queries over one scene. One object per thread.
class Peer {
 public:
  virtual ~Peer() = default;
  /// Whether the ray may be asked at all (Embree aborts on some).
  virtual bool accepts(const Ray&) const { return true; }
  /// Precondition: accepts(ray). `near` are the triangles in whose boxes the line may be.
  virtual std::optional<PeerHit> closest(const Ray& ray,
                                         std::span<const std::uint32_t> near) const = 0;
};

inline constexpr std::array<const char*, 5> kPeerNames{"Embree", "Embree robust",
                                                       "Moeller-Trumbore float32",
                                                       "Moeller-Trumbore float64", "Woop float32"};

/// In the order of kPeerNames. The textbook tests see exactly the triangles whose boxes the line
/// may meet (a perfect tree), nearest t and then lowest id wins.
std::array<std::unique_ptr<Peer>, kPeerNames.size()> make_peers(
    std::span<const oracle::Triangle> triangles);

}  // namespace sightline::stress
