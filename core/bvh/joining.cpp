#include "core/bvh/joining.h"

#include <algorithm>
#include <cmath>

#include "core/bvh/triangle_tree.h"

namespace sightline {

namespace {

/// Of sizes within it of the median, float32 boxes in one scale have their full precision.
constexpr int kExponents = 40;

/// Exponent of the largest |coordinate|. Precondition: some is not 0.
int exponent_of(double largest) { return std::ilogb(largest); }

double largest_of(const Box3d& box) {
  double largest = 0;
  for (int k = 0; k < 3; ++k)
    largest = std::max({largest, std::abs(box.min[k]), std::abs(box.max[k])});
  return largest;
}

/// The placements whose size fits that of most.
std::vector<std::uint32_t> of_one_size(std::span<const Box3d> placed) {
  std::vector<int> exponents;
  for (const Box3d& box : placed) {
    if (box.empty()) continue;
    const double largest = largest_of(box);
    if (largest > 0) exponents.push_back(exponent_of(largest));
  }
  int median = 0;
  if (!exponents.empty()) {
    const auto middle = exponents.begin() + static_cast<std::ptrdiff_t>(exponents.size() / 2);
    std::nth_element(exponents.begin(), middle, exponents.end());
    median = *middle;
  }
  std::vector<std::uint32_t> chosen;
  for (std::uint32_t i = 0; i < placed.size(); ++i) {
    if (placed[i].empty()) continue;
    const double largest = largest_of(placed[i]);
    // What lies in the origin fits any scale.
    if (largest > 0 && std::abs(exponent_of(largest) - median) > kExponents) continue;
    chosen.push_back(i);
  }
  return chosen;
}

}  // namespace

std::vector<std::uint32_t> choose_joined(std::span<const MeshView> meshes,
                                         std::span<const PlacementView> placements,
                                         std::span<const Box3d> placed,
                                         std::uint32_t tree_triangles) {
  std::vector<std::uint32_t> chosen = of_one_size(placed);
  std::vector<std::uint32_t> uses(meshes.size());
  for (const std::uint32_t i : chosen) ++uses[placements[i].mesh];

  // Meshes by what copies of them cost.
  std::vector<std::uint32_t> order;
  std::uint64_t total = 0;
  for (std::uint32_t mesh = 0; mesh < meshes.size(); ++mesh) {
    if (uses[mesh] == 0) continue;
    order.push_back(mesh);
    total += meshes[mesh].triangle_count();
  }
  const auto copies = [&](std::uint32_t mesh) {
    return std::uint64_t{uses[mesh] - 1} * meshes[mesh].triangle_count();
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return copies(a) < copies(b); });
  const std::uint64_t most = std::max(total, kFreeCopies);
  std::vector<bool> joined(meshes.size());
  std::uint64_t copied = 0, triangles = 0, parts = 0;
  for (const std::uint32_t mesh : order) {
    const std::uint64_t all = copies(mesh) + meshes[mesh].triangle_count();
    if (copied + copies(mesh) > most || triangles + all > tree_triangles ||
        parts + uses[mesh] > LeafBlock::kPlacements)
      continue;
    copied += copies(mesh);
    triangles += all;
    parts += uses[mesh];
    joined[mesh] = true;
  }
  std::erase_if(chosen, [&](std::uint32_t i) { return !joined[placements[i].mesh]; });
  return chosen;
}

}  // namespace sightline
