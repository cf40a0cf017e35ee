#include "core/import/gltf/posed_numbers.h"

#include <algorithm>
#include <array>

#include "core/geometry/normal_map.h"

namespace sightline::gltf {

std::uint64_t SkinTurn::bytes() const {
  std::uint64_t sum = 0;
  for (const Set& set : sets) sum += set.joints->bytes() + set.weights->bytes();
  return sum;
}

bool PosedNumbers::load(std::uint64_t vertex, double* out, std::uint64_t& touched) const {
  if (!base_->load(vertex, out, touched)) return false;
  for (const auto& [weight, numbers] : targets_) {
    std::array<double, 4> added{};
    if (!numbers->load(vertex, added.data(), touched)) return false;
    const std::uint32_t count = std::min(components(), numbers->components());
    for (std::uint32_t c = 0; c < count; ++c) out[c] = out[c] + weight * added[c];
  }
  return skin_ == nullptr || turn(vertex, out, touched);
}

bool PosedNumbers::turn(std::uint64_t vertex, double* out, std::uint64_t& touched) const {
  Affine blend;
  for (auto& row : blend.m) std::fill(std::begin(row), std::end(row), 0.0);
  for (const SkinTurn::Set& set : skin_->sets) {
    std::array<double, 4> joint{}, weight{};
    if (!set.joints->load(vertex, joint.data(), touched)) return false;
    if (!set.weights->load(vertex, weight.data(), touched)) return false;
    for (std::size_t k = 0; k < 4; ++k) {
      if (weight[k] == 0) continue;
      const auto number = static_cast<std::size_t>(joint[k]);
      if (number >= skin_->joints->size()) return false;
      const Affine& matrix = (*skin_->joints)[number];
      for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 3; ++column) {
          blend.m[row][column] = blend.m[row][column] + weight[k] * matrix.m[row][column];
        }
      }
    }
  }
  const Vec3d v{out[0], out[1], out[2]};
  const NormalMap normals(blend);
  Vec3d turned;
  if (attribute_ == VertexAttribute::kNormal) {
    turned = normals.apply(v);
  } else {
    turned = unit_or_nan(blend.apply(v));
    if (normals.is_mirror()) out[3] = -out[3];
  }
  out[0] = turned.x;
  out[1] = turned.y;
  out[2] = turned.z;
  return true;
}

std::uint64_t PosedNumbers::bytes() const {
  std::uint64_t sum = base_->bytes();
  for (const auto& [weight, numbers] : targets_) sum += numbers->bytes();
  if (skin_ != nullptr && !is_shared_) sum += skin_->bytes();
  return sum;
}

}  // namespace sightline::gltf
