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

/// Positions or indices that one thread reads by itself.
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

/// Groups save time if the mesh is placed so often.
constexpr std::uint32_t kOften = 4;

std::shared_ptr<const CornerGroups> groups_of(const MeshView& mesh, const MeshFacts& facts) {
  auto groups = std::make_shared<CornerGroups>();
  groups->corners = corners_of(mesh);
  const std::size_t count =
      groups->corners.empty() ? mesh.positions.size() : groups->corners.size();
  if (facts.uses < kOften || !facts.finite || count <= CornerGroups::kCorners) return groups;
  groups->boxes.resize((count + CornerGroups::kCorners - 1) / CornerGroups::kCorners);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3f& p = mesh.positions[groups->corners.empty() ? i : groups->corners[i]];
    groups->boxes[i / CornerGroups::kCorners].include(widened(p));
  }
  return groups;
}

/// Two numbers in one register, by the vector extensions of g++ and clang (docs/decisions/0029).
using Pair = double __attribute__((vector_size(16)));

/// One coordinate of mapped points and boxes, as Affine::apply computes it.
class MappedAxis {
 public:
  MappedAxis(const Affine& matrix, int axis) : m_(matrix.m[axis]) {}
  double of(const Vec3d& p) const { return ((m_[0] * p.x + m_[1] * p.y) + m_[2] * p.z) + m_[3]; }
  /// The least and the largest value of of() in the box: no mapped point is beyond, because each
  /// rounded product and sum is a monotone function of its operands.
  Pair range(const Box3d& box) const {
    return ((product(box, 0) + product(box, 1)) + product(box, 2)) + m_[3];
  }

 private:
  Pair product(const Box3d& box, int k) const {
    const double least = box.min[k], largest = box.max[k];
    return m_[k] < 0 ? m_[k] * Pair{largest, least} : m_[k] * Pair{least, largest};
  }
  const double* m_;
};

/// The union of the mapped boxes; not finite if a mapped corner is not.
Box3d grouped_bounds(const CornerGroups& groups, const Affine& matrix) {
  Box3d bounds;
  Pair zero{};  // no number if a corner is not finite
  for (int axis = 0; axis < 3; ++axis) {
    const MappedAxis map(matrix, axis);
    Pair low{kInfD, kInfD}, high{-kInfD, -kInfD};
    for (const Box3d& box : groups.boxes) {
      const Pair mapped = map.range(box);
      zero += mapped - mapped;
      low = mapped < low ? mapped : low;
      high = mapped > high ? mapped : high;
    }
    bounds.min[axis] = low[0];
    bounds.max[axis] = high[1];
  }
  if (!(zero[0] + zero[1] == 0)) bounds.max.x = kInfD;
  return bounds;
}

/// Sets placed[i] and is_loose[i].
void place(ScenePlan& plan, std::size_t i) {
  const PlacementView& view = plan.placements[i];
  plan.placed[i] = {};
  plan.is_loose[i] = 0;
  if (view.hidden) return;
  const CornerGroups& groups = *plan.groups[view.mesh];
  if (!groups.boxes.empty() && !view.world_from_mesh.is_diagonal()) {
    plan.placed[i] = grouped_bounds(groups, view.world_from_mesh);
    plan.is_loose[i] = is_finite(plan.placed[i].min) && is_finite(plan.placed[i].max) ? 1 : 0;
  }
  if (plan.is_loose[i] != 0) return;
  plan.placed[i] = world_bounds(plan.meshes[view.mesh], plan.facts[view.mesh], groups.corners,
                                view.world_from_mesh);
}

/// Widens one side of `bounds` to the corners of a placement, of which only groups that reach
/// beyond that side are read.
void include_side(const ScenePlan& plan, const PlacementView& view, int axis, bool largest,
                  Box3d& bounds) {
  double& side = largest ? bounds.max[axis] : bounds.min[axis];
  const auto beyond = [&](double x) { return largest ? x > side : x < side; };
  const MappedAxis map(view.world_from_mesh, axis);
  const CornerGroups& groups = *plan.groups[view.mesh];
  const MeshView& mesh = plan.meshes[view.mesh];
  const std::size_t count = groups.corners.empty() ? mesh.positions.size() : groups.corners.size();
  for (std::size_t g = 0; g < groups.boxes.size(); ++g) {
    const Box3d& box = groups.boxes[g];
    if (!beyond(map.range(box)[largest ? 1 : 0])) continue;
    const std::size_t end = std::min(count, (g + 1) * CornerGroups::kCorners);
    for (std::size_t i = g * CornerGroups::kCorners; i < end; ++i) {
      const Vec3f& p = mesh.positions[groups.corners.empty() ? i : groups.corners[i]];
      const double x = map.of(widened(p));
      if (beyond(x)) side = x;
    }
  }
}

Status check_placements(std::uint64_t count) {
  if (count <= kMaxTriangles) return success();
  return Error{ErrorKind::kTooLarge, "SCENE_TOO_LARGE",
               "meshes are placed " + std::to_string(count) + " times, a tree holds at most " +
                   std::to_string(kMaxTriangles),
               ""};
}

}  // namespace

Box3d ScenePlan::exact_bounds(std::size_t first, std::size_t count) const {
  Box3d exact;
  // The placement whose loose box reaches farthest comes first on each side: then few others are
  // examined.
  std::size_t farthest[3][2] = {};
  Box3d loose;
  for (std::size_t i = first; i < first + count; ++i) {
    if (placed[i].empty()) continue;
    if (is_loose[i] == 0) {
      exact.include(placed[i]);
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (placed[i].min[axis] < loose.min[axis]) farthest[axis][0] = i;
      if (placed[i].max[axis] > loose.max[axis]) farthest[axis][1] = i;
    }
    loose.include(placed[i]);
  }
  if (loose.empty()) return exact;
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool largest : {false, true}) {
      include_side(*this, placements[farthest[axis][largest ? 1 : 0]], axis, largest, exact);
      for (std::size_t i = first; i < first + count; ++i) {
        const bool reaches =
            largest ? placed[i].max[axis] > exact.max[axis] : placed[i].min[axis] < exact.min[axis];
        if (reaches && !placed[i].empty()) include_side(*this, placements[i], axis, largest, exact);
      }
    }
  }
  return exact;
}

Result<ScenePlan> moved_plan(const ScenePlan& before, std::span<const MovedPlacement> moved,
                             std::span<const FreshMesh> fresh) {
  ScenePlan plan = before;
  if (!moved.empty()) {
    const std::size_t count =
        std::max(plan.placements.size(), std::size_t{moved.back().number} + 1);
    if (Status status = check_placements(count); !status) return std::move(status).error();
    plan.placements.resize(count);
    plan.placed.resize(count);
    plan.is_loose.resize(count);
  }
  for (const FreshMesh& each : fresh) {
    if (each.number == plan.meshes.size()) {
      plan.meshes.emplace_back();
      plan.facts.emplace_back();
      plan.groups.emplace_back();
    }
    plan.meshes[each.number] = each.view;
    if (plan.facts[each.number].uses > 0) --plan.distinct;
    plan.facts[each.number] = facts_of(each.view.positions);
    plan.groups[each.number] = nullptr;
  }
  for (const MovedPlacement& each : moved) {
    PlacementView& view = plan.placements[each.number];
    view.mesh = each.mesh;
    view.world_from_mesh = each.world_from_mesh;
    view.hidden = each.hidden;
    if (view.hidden) continue;
    // All placements of a mesh may have been hidden so far.
    MeshFacts& facts = plan.facts[view.mesh];
    if (facts.uses == 0) {
      facts.uses = 1;
      ++plan.distinct;
      plan.groups[view.mesh] = groups_of(plan.meshes[view.mesh], facts);
    }
  }
  parallel_for(moved.size(), [&](std::size_t k) { place(plan, moved[k].number); });
  plan.bounds = plan.exact_bounds(0, plan.placed.size());
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
  if (Status status = check_placements(plan.placements.size()); !status)
    return std::move(status).error();
  plan.facts.resize(plan.meshes.size());
  parallel_for(plan.meshes.size(),
               [&](std::size_t i) { plan.facts[i] = facts_of(plan.meshes[i].positions); });
  const auto first = first_with_same_content(plan.meshes, plan.facts);
  for (PlacementView& placement : plan.placements) {
    placement.mesh = first[placement.mesh];
    if (placement.hidden) continue;
    if (plan.facts[placement.mesh].uses++ == 0) ++plan.distinct;
  }

  plan.groups.resize(plan.meshes.size());
  parallel_for(plan.meshes.size(), [&](std::size_t i) {
    if (plan.facts[i].uses > 0) plan.groups[i] = groups_of(plan.meshes[i], plan.facts[i]);
  });
  plan.placed.resize(plan.placements.size());
  plan.is_loose.resize(plan.placements.size());
  parallel_for(plan.placements.size(), [&](std::size_t i) { place(plan, i); });
  plan.bounds = plan.exact_bounds(0, plan.placed.size());
  return plan;
}

}  // namespace sightline
