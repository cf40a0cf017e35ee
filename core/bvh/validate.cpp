#include "core/bvh/validate.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/bvh/tree_corners.h"
#include "core/bvh/triangle_tree.h"
#include "core/geometry/rounding.h"

namespace sightline {

namespace {

/// What is wrong, if anything; empty optionals all the way up mean a good tree.
using Fault = std::optional<std::string>;

/// A box as its parent stores it. The root has none: its box is everything.
struct StoredBox {
  double lower[3] = {-kInfD, -kInfD, -kInfD};
  double upper[3] = {kInfD, kInfD, kInfD};

  bool contains(int axis, double x) const { return lower[axis] <= x && x <= upper[axis]; }
};

StoredBox box_of(const WideNode& node, std::size_t child) {
  StoredBox box;
  for (int k = 0; k < 3; ++k) {
    box.lower[k] = static_cast<double>(node.lower[k][child]);
    box.upper[k] = static_cast<double>(node.upper[k][child]);
  }
  return box;
}

/// Walks everything that hangs from the root and proves its shape; what stands in the leaves is
/// the caller's to judge.
class ShapeCheck {
 public:
  explicit ShapeCheck(const WideTree& tree)
      : tree_(tree), granule_count_(tree.arena.used() / Arena::kGranule), taken_(granule_count_) {}

  /// leaf(blocks, box) returns a Fault.
  template <class Leaf>
  Fault run(const Leaf& leaf) {
    if (tree_.arena.used() % kNodeAlign != 0) {
      return "the arena holds " + std::to_string(tree_.arena.used()) +
             " bytes, not whole cache lines";
    }
    if (tree_.root != ChildRef::kEmpty) waiting_.push_back({tree_.root, 1, {}});
    while (!waiting_.empty()) {
      const Visit visit = waiting_.back();
      waiting_.pop_back();
      const bool is_leaf = ChildRef::is_leaf(visit.ref);
      if (Fault fault = is_leaf ? enter_leaf(visit, leaf) : enter_node(visit)) {
        return (is_leaf ? "the leaf at granule " : "the node at granule ") +
               std::to_string(is_leaf ? ChildRef::granule(visit.ref) : visit.ref) + *fault;
      }
    }
    return check_totals();
  }

 private:
  struct Visit {
    std::uint32_t ref;
    std::uint32_t depth;
    StoredBox box;
  };

  /// Claims the place of a node or leaf. A second claim finds it taken: no cycle, no sharing.
  Fault take(std::uint32_t granule, std::size_t bytes) {
    const std::size_t count = bytes / Arena::kGranule;
    if (granule >= granule_count_ || granule_count_ - granule < count) {
      return ": needs " + std::to_string(count) + " granules, the arena has " +
             std::to_string(granule_count_);
    }
    for (std::size_t i = granule; i < granule + count; ++i) {
      if (taken_[i]) return ": overlaps what was reached another way";
      taken_[i] = true;
    }
    taken_count_ += count;
    return {};
  }

  template <class Leaf>
  Fault enter_leaf(const Visit& visit, const Leaf& leaf) {
    std::uint32_t granule = ChildRef::granule(visit.ref);
    for (std::uint32_t i = 0; i < ChildRef::blocks(visit.ref); ++i) {
      // The first granule of a block says how many follow.
      if (Fault fault = take(granule, Arena::kGranule)) return fault;
      const std::uint32_t granules =
          reinterpret_cast<const LeafBlock*>(tree_.arena.at(granule))->granules();
      const std::size_t rest = (granules - 1) * Arena::kGranule;
      if (rest > 0) {
        if (Fault fault = take(granule + 1, rest)) return fault;
      }
      granule += granules;
    }
    block_count_ += ChildRef::blocks(visit.ref);
    return leaf(tree_.blocks(visit.ref), visit.box);
  }

  Fault enter_node(const Visit& visit) {
    // Bits above the granule's would be lost on the way to an address.
    if (visit.ref != ChildRef::granule(visit.ref)) return ": is no place in any arena";
    if (visit.ref % (kNodeAlign / Arena::kGranule) != 0) return ": begins within a cache line";
    if (Fault fault = take(visit.ref, sizeof(WideNode))) return fault;
    if (visit.depth > kMaxTreeDepth) {
      return ": is " + std::to_string(visit.depth) + " deep, at most " +
             std::to_string(kMaxTreeDepth) + " are walked";
    }
    ++node_count_;
    depth_ = std::max(depth_, visit.depth);
    const WideNode& node = tree_.node(visit.ref);
    if (Fault fault = check_orders(node)) return fault;
    for (std::size_t i = 0; i < kArity; ++i) {
      if (Fault fault = check_child(node, i, visit.box)) {
        return ", child " + std::to_string(i) + *fault;
      }
      if (node.child[i] != ChildRef::kEmpty)
        waiting_.push_back({node.child[i], visit.depth + 1, box_of(node, i)});
    }
    return {};
  }

  static Fault check_child(const WideNode& node, std::size_t i, const StoredBox& parent) {
    const StoredBox box = box_of(node, i);
    for (int k = 0; k < 3; ++k) {
      const char axis[] = {' ', "xyz"[k], '\0'};
      if (node.child[i] == ChildRef::kEmpty) {
        if (box.lower[k] != kInfD || box.upper[k] != -kInfD)
          return ": is empty and could be hit, axis" + std::string(axis);
        continue;
      }
      if (!std::isfinite(box.lower[k]) || !std::isfinite(box.upper[k]))
        return ": its box is not finite, axis" + std::string(axis);
      if (box.lower[k] > box.upper[k]) return ": its box is inside out, axis" + std::string(axis);
      if (!parent.contains(k, box.lower[k]) || !parent.contains(k, box.upper[k]))
        return ": its box leaves the parent's, axis" + std::string(axis);
    }
    return {};
  }

  static Fault check_orders(const WideNode& node) {
    for (std::size_t octant = 0; octant < 8; ++octant) {
      std::uint32_t seen = 0;
      for (std::uint32_t i = 0; i < kArity; ++i) seen |= 1u << (node.order[octant] >> (3 * i) & 7u);
      if (seen != 0xffu || node.order[octant] >> (3 * kArity) != 0)
        return ": the order of octant " + std::to_string(octant) + " does not name every child";
    }
    return {};
  }

  Fault check_totals() const {
    for (std::size_t i = granule_count_ - std::min(granule_count_, kLineGranules);
         i < granule_count_; ++i) {
      if (taken_[i]) return "the last cache line is in use";
    }
    std::size_t lost = 0, first = 0;
    if (taken_count_ != granule_count_) {
      for (std::size_t i = granule_count_; i-- > 0;) {
        if (taken_[i] || is_gap(i)) continue;
        ++lost;
        first = i;
      }
    }
    if (lost > 0)
      return std::to_string(lost) + " granules are never reached, granule " +
             std::to_string(first) + " first";
    const auto differ = [](const char* what, std::uint64_t stated, std::uint64_t counted) {
      return "the tree states " + std::to_string(stated) + " " + what + " and has " +
             std::to_string(counted);
    };
    if (tree_.node_count != node_count_) return differ("nodes", tree_.node_count, node_count_);
    if (tree_.block_count != block_count_) return differ("blocks", tree_.block_count, block_count_);
    if (tree_.depth != depth_) return differ("levels", tree_.depth, depth_);
    return {};
  }

  /// Zeros up to the end of a cache line in which blocks end, or in the last cache line.
  bool is_gap(std::size_t granule) const {
    const std::byte* const at = tree_.arena.at(static_cast<std::uint32_t>(granule));
    const bool is_last = granule_count_ - granule <= kLineGranules;
    return (is_last || (granule % 2 != 0 && taken_[granule - 1])) &&
           std::all_of(at, at + Arena::kGranule, [](std::byte b) { return b == std::byte{0}; });
  }

  static constexpr std::size_t kLineGranules = kNodeAlign / Arena::kGranule;

  const WideTree& tree_;
  std::size_t granule_count_;
  std::vector<bool> taken_;
  std::size_t taken_count_ = 0;
  std::vector<Visit> waiting_;
  std::uint64_t node_count_ = 0;
  std::uint64_t block_count_ = 0;
  std::uint32_t depth_ = 0;
};

Fault check_lane_count(const LeafBlock& block) {
  if (block.lane_count() >= 1 && block.lane_count() <= kLanes) return {};
  return ": a block has " + std::to_string(block.lane_count()) + " lanes";
}

/// Which of `count` things stood in a leaf, each at most once.
class Attendance {
 public:
  Attendance(std::string what, std::size_t count) : what_(std::move(what)), seen_(count) {}

  Fault enter(std::uint32_t i) {
    if (i >= seen_.size()) return ": holds " + name(i) + " of " + std::to_string(seen_.size());
    if (seen_[i]) return ": holds " + name(i) + ", which another leaf holds too";
    seen_[i] = true;
    return {};
  }
  bool seen(std::size_t i) const { return seen_[i]; }
  std::string name(std::size_t i) const { return what_ + " " + std::to_string(i); }

 private:
  std::string what_;
  std::vector<bool> seen_;
};

/// Bits, not values: a kernel may not see -0 where the mesh has 0.
bool same_bits(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

/// Precondition: the used lanes hold triangles of the mesh.
Fault check_block(const LeafBlock& block, const MeshView& mesh) {
  if (block.capacity() == 0) return ": a block has no vertices";
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const std::uint32_t triangle = block.triangle(lane);
    if (lane >= block.lane_count() && triangle != block.triangle(0))
      return ": lane " + std::to_string(lane) + " is unused and does not repeat the first";
    const auto index = mesh.indices.corners(triangle);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      if (block.vertex(corner, lane) >= block.capacity()) {
        return ": corner " + std::to_string(corner) + " of triangle " + std::to_string(triangle) +
               " is vertex " + std::to_string(block.vertex(corner, lane)) + " of " +
               std::to_string(block.capacity());
      }
      const Vec3f stored = block.corner(corner, lane);
      const Vec3f& p = mesh.positions[index[corner]];
      const Vec3f& q = mesh.positions[index[corner == 2 ? 0 : corner + 1]];
      for (int axis = 0; axis < 3; ++axis) {
        if (!same_bits(stored[axis], p[axis]))
          return ": corner " + std::to_string(corner) + " of triangle " + std::to_string(triangle) +
                 " is not the mesh's";
        const double edge = std::abs(static_cast<double>(q[axis]) - static_cast<double>(p[axis]));
        // The difference may have been rounded down.
        if (!(static_cast<double>(block.edge_max()) >= next_above(edge)))
          return ": edge_max is below an edge of triangle " + std::to_string(triangle);
      }
    }
  }
  return {};
}

Fault check_facts(const WideTree& tree, const Box3d& bounds) {
  if (!(tree.bounds == bounds)) return "the tree's bounds are not those of its content";
  const int exponent = bounds.empty() ? 0 : choose_scale_exponent(bounds);
  if (tree.scale_exponent == exponent) return {};
  return "the tree's units are 2^" + std::to_string(tree.scale_exponent) + ", its content asks 2^" +
         std::to_string(exponent);
}

Status verdict(Fault fault) {
  if (!fault) return success();
  return Error{ErrorKind::kMalformed, "TREE_INVALID", "not a sound tree: " + *fault, ""};
}

Fault find_fault(const WideTree& tree, std::span<const TreePart> parts) {
  const PartNumbers numbering(parts);
  const auto corners_of = [&](PartNumbers::Place place) {
    const TreePart& part = parts[place.part];
    return tree_corners(part.mesh, place.triangle, part.world_from_mesh);
  };
  // The meshes say what must be there, and in which units.
  Box3d bounds;
  for (std::uint32_t i = 0; i < numbering.count(); ++i) {
    const TreeCorners corners = corners_of(numbering.place_of(i));
    if (!corners.usable) continue;
    for (const Vec3d& p : corners.at) bounds.include(p);
  }
  if (Fault fault = check_facts(tree, bounds)) return fault;
  const double scale = std::ldexp(1.0, tree.scale_exponent);

  Attendance present("triangle", numbering.count());
  const auto check_triangle = [&](PartNumbers::Place place, const StoredBox& box) -> Fault {
    const std::uint32_t count = parts[place.part].mesh.triangle_count();
    if (place.triangle >= count) {
      return ": holds triangle " + std::to_string(place.triangle) + " of " + std::to_string(count);
    }
    const std::optional<std::uint32_t> number = numbering.number(place);
    if (!number) {
      return ": holds triangle " + std::to_string(place.triangle) + ", which is not of this tree";
    }
    if (Fault fault = present.enter(*number)) return fault;
    const TreeCorners corners = corners_of(place);
    if (!corners.usable) return ": holds " + present.name(*number) + ", which nothing can hit";
    for (const Vec3d& p : corners.at) {
      for (int k = 0; k < 3; ++k) {
        if (!box.contains(k, p[k] * scale))
          return ": its box does not contain " + present.name(*number);
      }
    }
    return {};
  };
  Fault fault = ShapeCheck(tree).run([&](const LeafBlocks& blocks, const StoredBox& box) -> Fault {
    for (const LeafBlock& block : blocks) {
      if (Fault f = check_lane_count(block)) return f;
      if (block.placement() >= parts.size()) {
        return ": a block is of placement " + std::to_string(block.placement()) + " of " +
               std::to_string(parts.size());
      }
      for (std::uint32_t lane = 0; lane < block.lane_count(); ++lane) {
        if (Fault f = check_triangle({block.placement(), block.triangle(lane)}, box)) return f;
      }
      if (Fault f = check_block(block, parts[block.placement()].mesh)) return f;
    }
    return {};
  });
  if (fault) return fault;
  for (std::uint32_t i = 0; i < numbering.count(); ++i) {
    if (!present.seen(i) && corners_of(numbering.place_of(i)).usable)
      return present.name(i) + " is in no leaf";
  }
  return {};
}

Fault find_fault(const WideTree& tree, std::span<const Box3d> placed) {
  Box3d bounds;
  for (const Box3d& box : placed) bounds.include(box);
  if (Fault fault = check_facts(tree, bounds)) return fault;
  const double scale = std::ldexp(1.0, tree.scale_exponent);

  Attendance present("placement", placed.size());
  const auto check_placement = [&](std::uint32_t i, const StoredBox& box) -> Fault {
    if (Fault fault = present.enter(i)) return fault;
    for (int k = 0; k < 3; ++k) {
      if (!box.contains(k, placed[i].min[k] * scale) || !box.contains(k, placed[i].max[k] * scale))
        return ": its box does not contain " + present.name(i);
    }
    return {};
  };
  Fault fault = ShapeCheck(tree).run([&](const LeafBlocks& blocks, const StoredBox& box) -> Fault {
    // Placements are entered one leaf, one block at a time.
    if (blocks.size() != 1)
      return ": has " + std::to_string(blocks.size()) + " blocks of placements";
    const LeafBlock& block = blocks.front();
    if (Fault f = check_lane_count(block)) return f;
    for (std::uint32_t lane = 0; lane < block.lane_count(); ++lane) {
      if (Fault f = check_placement(block.triangle(lane), box)) return f;
    }
    return {};
  });
  if (fault) return fault;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    if (!present.seen(i)) return present.name(i) + " is in no leaf";
  }
  return {};
}

}  // namespace

Status validate_triangle_tree(const WideTree& tree, const MeshView& mesh,
                              const Affine* world_from_mesh) {
  const TreePart part{mesh, world_from_mesh};
  return validate_triangle_tree(tree, {&part, 1});
}

Status validate_triangle_tree(const WideTree& tree, std::span<const TreePart> parts) {
  return verdict(find_fault(tree, parts));
}

Status validate_top_tree(const WideTree& tree, std::span<const Box3d> placed) {
  return verdict(find_fault(tree, placed));
}

}  // namespace sightline
