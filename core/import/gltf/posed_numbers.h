#pragma once
/// Vertex attributes that morph targets or a skin change.

#include <memory>
#include <utility>
#include <vector>

#include "core/import/gltf/skinning.h"
#include "core/scene/vertex_numbers.h"

namespace sightline::gltf {

/// What turns the normals and tangents of a skinned primitive. All members live as long as this
/// struct.
struct SkinTurn {
  /// JOINTS_n and WEIGHTS_n, 4 numbers for each vertex.
  struct Set {
    std::shared_ptr<const VertexNumbers> joints;
    std::shared_ptr<const VertexNumbers> weights;
  };
  std::shared_ptr<const JointMatrices> joints;
  std::vector<Set> sets;

  /// As VertexNumbers::bytes, of all sets.
  std::uint64_t bytes() const;
};

/// An attribute of a posed primitive. For each vertex and number, in float64 without FMA:
///   v = base;  v = v + w_k d_k         over the morph targets whose weight is not zero
/// Then, for a normal or tangent of a skinned primitive, with the joints and weights of pose()
/// (skinning.h), which blend matrices as they blend positions:
///   M = 0;  M = M + w_k J_k
/// A normal is NormalMap(M).apply(v). A tangent is M v made unit; its fourth number changes sign if
/// M is a reflection. Cost: that of loading each part, and 9 products for each joint.
class PosedNumbers : public VertexNumbers {
 public:
  using Numbers = std::shared_ptr<const VertexNumbers>;
  /// attribute  what `base` is
  /// targets    weights of morph targets with what they add; of no more components than `base`
  /// skin       null: none. Precondition: `attribute` is a normal or a tangent if it is not null.
  /// is_shared  true: another attribute counts the bytes of the skin
  PosedNumbers(VertexAttribute attribute, Numbers base,
               std::vector<std::pair<double, Numbers>> targets,
               std::shared_ptr<const SkinTurn> skin, bool is_shared)
      : attribute_(attribute),
        base_(std::move(base)),
        targets_(std::move(targets)),
        skin_(std::move(skin)),
        is_shared_(is_shared) {}

  std::uint32_t components() const override { return base_->components(); }
  bool load(std::uint64_t vertex, double* out, std::uint64_t& touched) const override;
  std::uint64_t bytes() const override;

 private:
  bool turn(std::uint64_t vertex, double* out, std::uint64_t& touched) const;

  VertexAttribute attribute_;
  Numbers base_;
  std::vector<std::pair<double, Numbers>> targets_;
  std::shared_ptr<const SkinTurn> skin_;
  bool is_shared_;
};

}  // namespace sightline::gltf

// Tests: tests/integration/posed_attributes_test.py
