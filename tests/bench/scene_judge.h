#pragma once
/// The exact answer to a ray of a scene, by the oracle. Scenes with too many placed triangles to
/// list are judged placement by placement.

#include <memory>
#include <optional>
#include <vector>

#include "core/query/hit_batch.h"
#include "core/scene/scene.h"
#include "tests/oracle/scene_oracle.h"

namespace sightline::bench {

class SceneJudge {
 public:
  /// The scene must outlive it.
  explicit SceneJudge(const Scene& scene);

  struct Verdict {
    TriangleId id;
    oracle::Rational t;
    double t_rounded = 0;
  };
  /// The closest hit, or nothing.
  std::optional<Verdict> closest(const Ray& ray) const;
  /// Whether this triangle is met at exactly this t: another name for the same place.
  bool is_tie(const Ray& ray, TriangleId id, const oracle::Rational& t) const;
  /// Asking is slow (milliseconds): judge few rays.
  bool slow() const { return !listed_; }

 private:
  std::optional<Verdict> closest_of_placements(const Ray& ray) const;

  const Scene& scene_;
  std::vector<std::size_t> first_;  ///< per instance: the number of its first triangle in the list
  std::unique_ptr<oracle::SceneOracle> listed_;
  std::vector<oracle::Bounds> bounds_;  ///< per instance, when not listed
};

}  // namespace sightline::bench
