#include "tests/stress/contestant.h"

#include "tests/stress/textbook.h"

namespace sightline::stress {
namespace {

class EmbreePeer : public Peer {
 public:
  EmbreePeer(std::span<const oracle::Triangle> triangles, bool robust)
      : scene_(triangles, robust) {}
  bool accepts(const Ray& ray) const override { return crosscheck::EmbreeScene::accepts(ray); }
  std::optional<PeerHit> closest(const Ray& ray, std::span<const std::uint32_t>) const override {
    const auto hit = scene_.closest(ray);
    if (!hit) return std::nullopt;
    return PeerHit{hit->triangle, static_cast<double>(hit->t)};
  }

 private:
  crosscheck::EmbreeScene scene_;
};

/// One test of one triangle, tried on everything near the line.
template <class Real, class PreparedRay, auto kTest>
class TextbookPeer : public Peer {
 public:
  explicit TextbookPeer(std::span<const oracle::Triangle> triangles) {
    triangles_.reserve(triangles.size());
    for (const oracle::Triangle& triangle : triangles) triangles_.emplace_back(triangle);
  }
  std::optional<PeerHit> closest(const Ray& ray,
                                 std::span<const std::uint32_t> near) const override {
    const PreparedRay prepared(ray);
    std::optional<PeerHit> best;
    for (const std::uint32_t id : near) {
      const std::optional<Real> t = kTest(prepared, triangles_[id]);
      if (!t) continue;
      const auto value = static_cast<double>(*t);
      if (!best || value < best->t || (value == best->t && id < best->triangle))
        best = PeerHit{id, value};
    }
    return best;
  }

 private:
  std::vector<RealTriangle<Real>> triangles_;
};

}  // namespace

std::array<std::unique_ptr<Peer>, kPeerNames.size()> make_peers(
    std::span<const oracle::Triangle> triangles) {
  return {
      std::make_unique<EmbreePeer>(triangles, false), std::make_unique<EmbreePeer>(triangles, true),
      std::make_unique<TextbookPeer<float, RealRay<float>, &moeller_trumbore<float>>>(triangles),
      std::make_unique<TextbookPeer<double, RealRay<double>, &moeller_trumbore<double>>>(triangles),
      std::make_unique<TextbookPeer<float, WoopRay, &woop>>(triangles)};
}

}  // namespace sightline::stress
