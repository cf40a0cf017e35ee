#pragma once
/// AnimationSampler: the transforms and weights that an animation gives to nodes at a time.

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/import/gltf/accessor.h"
#include "core/import/gltf/gltf_document.h"
#include "core/scene/poser.h"

namespace sightline::gltf {

/// The number of morph targets of each mesh.
std::vector<std::uint32_t> morph_targets(const GltfDocument& document);

/// Samples the animations of a document by [glTF2] 3.11 and appendix C, in float64 without FMA.
/// Before the first key and after the last one the value is that key's. Between the keys k and k + 1
/// at u = (t - t_k) / d, with d = t_{k+1} - t_k:
///   STEP         v_k
///   LINEAR       (1 - u) v_k + u v_{k+1}; rotations: with c = (x x' + y y' + z z') + w w', s = 1 or
///                -1 as c, and a = acos(min(|c|, 1)), (sin(a (1 - u)) / sin a) v_k +
///                (s (sin(a u) / sin a)) v_{k+1}; where sin a = 0, (1 - u) v_k + (s u) v_{k+1}
///   CUBICSPLINE  ((((2 uuu - 3 uu) + 1) v_k + (d ((uuu - 2 uu) + u)) b_k) + (3 uu - 2 uuu) v_{k+1}) +
///                (d (uuu - uu)) a_{k+1}, with uu = u u and uuu = uu u; rotations are then divided by
///                their length
/// Not thread-safe. All arguments must outlive it.
class AnimationSampler {
 public:
  AnimationSampler(const GltfDocument& document, AccessorReader& accessors)
      : document_(document), accessors_(accessors), targets_(morph_targets(document)) {}

  /// Checks where the keys of an animation are and of which types; reads none. Errors:
  /// ANIMATION_INVALID naming the animation.
  Status check(std::size_t animation);
  /// The time of the last key of all samplers in seconds. Errors: those of check.
  Result<double> duration(std::size_t animation);
  /// The transforms and weights of all nodes that the animation targets, ascending by node. Cost:
  /// reads all times, and the values beside `seconds`. Errors: ANIMATION_INVALID (times that do not
  /// rise; a node with a matrix; a transform that TRANSFORM_INVALID refuses; more than 2^22 weights).
  Result<std::vector<NodeChange>> sample(std::size_t animation, double seconds);

 private:
  /// The keys beside a time.
  struct Keys {
    std::uint64_t first = 0, second = 0;  ///< equal: the value is that of the key
    double u = 0;                         ///< from 0 at the first to 1 at the second
    double seconds = 0;                   ///< from the first to the second
  };
  struct Views {
    AccessorView input, output;
  };
  /// `reads` is false: elements that have to be decoded have no bytes.
  Result<AccessorView> view(std::uint32_t accessor, bool reads);
  /// The checked views of a channel's sampler; `width` is the number of numbers of a value.
  Result<Views> views(const AnimationEntry& animation, const AnimationChannel& channel,
                      std::size_t width, bool reads);
  std::size_t width_of(const AnimationChannel& channel) const;
  Result<Keys> keys_at(const AccessorView& input, double seconds);
  Result<std::vector<double>> value(const AnimationEntry& animation,
                                    const AnimationChannel& channel, double seconds);

  const GltfDocument& document_;
  AccessorReader& accessors_;
  const std::vector<std::uint32_t> targets_;
  /// By accessor, and whether it was read.
  std::map<std::pair<std::uint32_t, bool>, AccessorView> views_;
  std::map<std::uint32_t, Keys> keys_;  ///< by accessor of times, for one call of sample
};

}  // namespace sightline::gltf

// Tests: tests/integration/poses_test.py
