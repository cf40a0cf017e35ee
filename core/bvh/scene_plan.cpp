#include "core/bvh/scene_plan.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <string>
#include <unordered_map>

#include "core/base/column.h"
#include "core/base/content_hash.h"
#include "core/base/parallel.h"
#include "core/bvh/triangle_tree.h"
#include "core/geometry/rounding.h"

namespace sightline {

namespace {

/// Positions or indices that one thread looks at by itself.
constexpr std::size_t kGrain = 1u << 16;

Vec3d widened(const Vec3f& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

MeshFacts with(std::span<const Vec3f> positions, MeshFacts facts) {
  // In float32, which is as good; with doubles and a branch for each it takes three times as long.
  Vec3f low{kInfF, kInfF, kInfF}, high{-kInfF, -kInfF, -kInfF};
  float zero = 0;  // no number from the first position on that is not finite
  for (const Vec3f& p : positions) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    zero += (p.x - p.x) + (p.y - p.y) + (p.z - p.z);
  }
  if (zero == 0) {
    facts.box.include(Box3d{widened(low), widened(high)});
    return facts;
  }
  facts.finite = false;
  for (const Vec3f& p : positions) {
    if (is_finite(widened(p))) facts.box.include(widened(p));
  }
  return facts;
}

MeshFacts facts_of(std::span<const Vec3f> positions) {
  return parallel_reduce(
      0, positions.size(), kGrain, MeshFacts{},
      [&](std::size_t begin, std::size_t end, const MeshFacts& facts) {
        return with(positions.subspan(begin, end - begin), facts);
      },
      [](MeshFacts a, const MeshFacts& b) {
        a.finite = a.finite && b.finite;
        a.box.include(b.box);
        return a;
      });
}

/// The positions that no triangle uses must not widen a box. Empty: all are used.
std::vector<std::uint32_t> corners_of(const MeshView& mesh) {
  if (mesh.all_used) return {};
  const bool in_order = mesh.indices.listed().empty();
  if (in_order && mesh.indices.size() >= mesh.positions.size()) return {};
  Column<std::uint8_t> used(mesh.positions.size(), 0);
  const std::size_t chunks = (mesh.indices.size() + kGrain - 1) / kGrain;
  parallel_for(chunks, [&](std::size_t chunk) {
    const std::size_t begin = chunk * kGrain;
    const std::size_t end = std::min(mesh.indices.size(), begin + kGrain);
    for (std::size_t i = begin; i < end; ++i) {
      std::atomic_ref(used[mesh.indices[i]]).store(1, std::memory_order_relaxed);
    }
  });
  if (std::find(used.begin(), used.end(), 0) == used.end()) return {};
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i < used.size(); ++i) {
    if (used[i] != 0) corners.push_back(i);
  }
  return corners;
}

struct PlacedBounds {
  Box3d box;
  bool finite = true;
};

/// World bounds of the triangles whose three corners are finite in the world.
Box3d world_bounds(const MeshView& mesh, const MeshFacts& facts,
                   std::span<const std::uint32_t> corners, const Affine& matrix) {
  if (mesh.indices.empty()) return {};
  if (facts.finite && corners.empty() && matrix.is_diagonal()) {
    // Each world coordinate is a monotone function of one of the mesh, rounding included.
    const Vec3d a = matrix.apply(facts.box.min), b = matrix.apply(facts.box.max);
    Box3d bounds;
    bounds.include(a);
    bounds.include(b);
    if (is_finite(a) && is_finite(b)) return bounds;
  }
  const std::size_t count = corners.empty() ? mesh.positions.size() : corners.size();
  const PlacedBounds placed = parallel_reduce(
      0, count, kGrain, PlacedBounds{},
      [&](std::size_t begin, std::size_t end, PlacedBounds within) {
        for (std::size_t i = begin; i < end; ++i) {
          const Vec3d p = matrix.apply(mesh.positions[corners.empty() ? i : corners[i]]);
          within.finite = within.finite && is_finite(p);
          within.box.include(p);
        }
        return within;
      },
      [](PlacedBounds a, const PlacedBounds& b) {
        a.finite = a.finite && b.finite;
        a.box.include(b.box);
        return a;
      });
  if (facts.finite && placed.finite) return placed.box;
  // Rare: only the corners of triangles that are finite as a whole count.
  Box3d bounds;
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const Vec3d a = matrix.apply(mesh.positions[mesh.indices[i]]);
    const Vec3d b = matrix.apply(mesh.positions[mesh.indices[i + 1]]);
    const Vec3d c = matrix.apply(mesh.positions[mesh.indices[i + 2]]);
    if (!is_finite(Triangle{a, b, c})) continue;
    bounds.include(a);
    bounds.include(b);
    bounds.include(c);
  }
  return bounds;
}

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

/// For each mesh the first with the same content. Only meshes that agree in what is known of them
/// anyway are read, and a hash decides nothing by itself.
std::vector<std::uint32_t> first_with_same_content(std::span<const MeshView> meshes,
                                                   std::span<const MeshFacts> facts) {
  std::vector<std::uint32_t> first(meshes.size());
  std::unordered_multimap<std::uint64_t, std::uint32_t> by_look;
  const auto look_of = [&](std::uint32_t i) {
    ContentHash hash;
    const std::size_t sizes[] = {meshes[i].positions.size(), meshes[i].indices.size()};
    hash.add(std::as_bytes(std::span(sizes)));
    const double largest[] = {facts[i].largest(0), facts[i].largest(1), facts[i].largest(2)};
    hash.add(std::as_bytes(std::span(largest)));
    return hash.value();
  };
  std::vector<std::uint64_t> looks(meshes.size());
  for (std::uint32_t i = 0; i < meshes.size(); ++i) {
    first[i] = i;
    by_look.emplace(looks[i] = look_of(i), i);
  }
  std::vector<std::uint64_t> content(meshes.size());
  parallel_for(meshes.size(), [&](std::size_t i) {
    if (by_look.count(looks[i]) < 2) return;
    ContentHash hash;
    hash.add(std::as_bytes(meshes[i].positions));
    hash.add(std::as_bytes(meshes[i].indices.listed()));
    content[i] = hash.value();
  });
  std::unordered_map<std::uint64_t, std::uint32_t> by_content;
  for (std::uint32_t i = 0; i < meshes.size(); ++i) {
    if (by_look.count(looks[i]) < 2) continue;
    const auto [place, is_new] = by_content.try_emplace(content[i], i);
    const MeshView& known = meshes[place->second];
    if (!is_new && same_bytes(known.positions, meshes[i].positions) &&
        known.indices == meshes[i].indices) {
      first[i] = place->second;
    }
  }
  return first;
}

Box3d placed_bounds(const ScenePlan& plan, std::size_t i, std::span<const std::uint32_t> corners) {
  const PlacementView& view = plan.placements[i];
  if (view.hidden) return {};
  return world_bounds(plan.meshes[view.mesh], plan.facts[view.mesh], corners, view.world_from_mesh);
}

}  // namespace

ScenePlan moved_plan(const ScenePlan& before, std::span<const MovedPlacement> moved) {
  ScenePlan plan = before;
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> corners;
  for (const MovedPlacement& each : moved) {
    PlacementView& view = plan.placements[each.number];
    view.world_from_mesh = each.world_from_mesh;
    view.hidden = each.hidden;
    if (view.hidden) continue;
    const auto [known, is_new] = corners.try_emplace(view.mesh);
    if (is_new) known->second = corners_of(plan.meshes[view.mesh]);
    // All placements of a mesh may have been hidden so far.
    MeshFacts& facts = plan.facts[view.mesh];
    if (facts.uses == 0) {
      facts.uses = 1;
      ++plan.distinct;
    }
  }
  parallel_for(moved.size(), [&](std::size_t k) {
    const std::uint32_t i = moved[k].number;
    const auto found = corners.find(plan.placements[i].mesh);
    plan.placed[i] = placed_bounds(
        plan, i, found == corners.end() ? std::span<const std::uint32_t>() : found->second);
  });
  plan.bounds = {};
  for (const Box3d& box : plan.placed) plan.bounds.include(box);
  return plan;
}

Result<ScenePlan> plan_scene(std::vector<MeshView> meshes, std::vector<PlacementView> placements,
                             std::uint32_t tree_triangles) {
  constexpr std::uint64_t kMostTriangles = 0xffffffffu;
  ScenePlan plan;
  plan.tree_triangles = tree_triangles;
  plan.meshes = std::move(meshes);
  plan.placements = std::move(placements);
  for (const MeshView& mesh : plan.meshes) {
    if (mesh.indices.size() / 3 > kMostTriangles) {
      return Error{ErrorKind::kTooLarge, "SCENE_TOO_LARGE",
                   "a mesh has " + std::to_string(mesh.indices.size() / 3) +
                       " triangles, at most " + std::to_string(kMostTriangles) + " are possible",
                   ""};
    }
  }
  if (plan.placements.size() > kMaxTriangles) {
    return Error{ErrorKind::kTooLarge, "SCENE_TOO_LARGE",
                 "meshes are placed " + std::to_string(plan.placements.size()) +
                     " times, a tree holds at most " + std::to_string(kMaxTriangles),
                 ""};
  }
  plan.facts.resize(plan.meshes.size());
  parallel_for(plan.meshes.size(),
               [&](std::size_t i) { plan.facts[i] = facts_of(plan.meshes[i].positions); });
  const auto first = first_with_same_content(plan.meshes, plan.facts);
  for (PlacementView& placement : plan.placements) {
    placement.mesh = first[placement.mesh];
    if (placement.hidden) continue;
    if (plan.facts[placement.mesh].uses++ == 0) ++plan.distinct;
  }

  std::vector<std::vector<std::uint32_t>> corners(plan.meshes.size());
  parallel_for(plan.meshes.size(), [&](std::size_t i) {
    if (plan.facts[i].uses > 0) corners[i] = corners_of(plan.meshes[i]);
  });
  plan.placed.resize(plan.placements.size());
  parallel_for(plan.placements.size(), [&](std::size_t i) {
    plan.placed[i] = placed_bounds(plan, i, corners[plan.placements[i].mesh]);
  });
  for (const Box3d& box : plan.placed) plan.bounds.include(box);
  return plan;
}

}  // namespace sightline
