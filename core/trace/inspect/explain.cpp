#include "core/trace/inspect/explain.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/exact_hit.h"
#include "core/trace/counting_sides.h"
#include "core/trace/leaf_triangle.h"

namespace sightline {

namespace {

struct Visit {
  std::uint32_t ref;
  std::int64_t parent;
  Box3d box;
  RayBoxAnswer met;
};

bool is_met(const RayBoxAnswer& answer) { return answer.outcome == RayBoxOutcome::kHit; }

class Walk {
 public:
  Walk(const SceneView& scene, const Ray& ray, const ResolvedFilter* resolved, std::size_t most)
      : scene_(scene), ray_(ray), resolved_(resolved), most_(most) {}

  Explanation run() {
    const SceneTree& trees = scene_.tree();
    if (trees.entries == 1) {
      enter(trees.placements[0], -1);
    } else {
      walk(trees.top, ray_, kNone, -1, [&](std::uint32_t ref, std::int64_t leaf) {
        for (const LeafBlock& block : trees.top.blocks(ref)) {
          for (std::uint32_t lane = 0; lane < block.lane_count(); ++lane)
            enter(trees.placements[block.triangle(lane)], leaf);
        }
      });
    }
    return std::move(result_);
  }

 private:
  void enter(const Placement& placement, std::int64_t parent) {
    const WideTree& tree = *scene_.tree().trees[placement.tree];
    Ray mapped = ray_;
    if (!placement.world_boxes) {
      for (int k = 0; k < 3; ++k) {
        mapped.origin[k] = mapped.direction[k] = 0;
        for (int j = 0; j < 3; ++j) {
          const double n = placement.space.inverse[k][j];
          mapped.origin[k] += n * (ray_.origin[j] - placement.space.translation[j]);
          mapped.direction[k] += n * ray_.direction[j];
        }
      }
    }
    walk(tree, mapped, placement.world_boxes ? kNone : placement.instance, parent,
         [&](std::uint32_t ref, std::int64_t leaf) { look_at(placement, tree, ref, leaf); });
  }

  template <class Leaf>
  void walk(const WideTree& tree, const Ray& ray, std::uint32_t instance, std::int64_t parent,
            Leaf leaf) {
    if (tree.root == ChildRef::kEmpty) return;
    const double scale = std::ldexp(1.0, -tree.scale_exponent);
    const auto meet = [&](const Box3d& box) {
      return ray_box(ray.origin, ray.direction, ray.tmin, ray.tmax, box);
    };
    std::vector<Visit> stack{{tree.root, parent, tree.bounds, meet(tree.bounds)}};
    while (!stack.empty()) {
      const Visit next = stack.back();
      stack.pop_back();
      if (result_.boxes.size() == most_) {
        result_.truncated = true;
        return;
      }
      const auto number = static_cast<std::int64_t>(result_.boxes.size());
      const bool is_leaf = ChildRef::is_leaf(next.ref);
      const bool behind_hit = is_met(next.met) && next.met.t_enter > best_;
      result_.boxes.push_back({next.parent, is_leaf, next.box, instance, next.met, behind_hit, {}});
      if (!is_met(next.met) || behind_hit) continue;
      if (is_leaf) {
        leaf(next.ref, number);
        continue;
      }
      const WideNode& node = tree.node(next.ref);
      const auto first = static_cast<std::ptrdiff_t>(stack.size());
      for (std::size_t i = 0; i < kArity; ++i) {
        if (node.child[i] == ChildRef::kEmpty) continue;
        Box3d box;
        for (int k = 0; k < 3; ++k) {
          box.min[k] = static_cast<double>(node.lower[k][i]) * scale;
          box.max[k] = static_cast<double>(node.upper[k][i]) * scale;
        }
        stack.push_back({node.child[i], number, box, meet(box)});
      }
      // The nearest is next; what is not met is told first.
      std::stable_sort(stack.begin() + first, stack.end(), [](const Visit& a, const Visit& b) {
        if (is_met(a.met) != is_met(b.met)) return is_met(a.met);
        return is_met(a.met) && a.met.t_enter > b.met.t_enter;
      });
    }
  }

  void look_at(const Placement& entered, const WideTree& tree, std::uint32_t ref,
               std::int64_t leaf) {
    for (const LeafBlock& block : tree.blocks(ref)) {
      const Placement& placement = (&entered)[block.placement()];
      for (std::uint32_t lane = 0; lane < block.lane_count(); ++lane) {
        ExplainedTriangle seen;
        seen.id = {placement.instance, block.triangle(lane)};
        const Triangle triangle = world_triangle(placement, block, lane);
        ExactT t;
        if (exact_hit(ray_.origin, ray_.direction, ray_.tmin, ray_.tmax, triangle, t)) {
          seen.t = t.rounded();
          const bool counts = does_count(seen.id, triangle);
          seen.verdict =
              counts ? ExplainedTriangle::Verdict::kHit : ExplainedTriangle::Verdict::kFiltered;
          if (counts) best_ = std::min(best_, seen.t);
        }
        result_.boxes[static_cast<std::size_t>(leaf)].triangles.push_back(seen);
      }
    }
  }

  bool does_count(TriangleId id, const Triangle& triangle) const {
    if (resolved_ == nullptr) return true;
    const int side = side_sign(ray_.direction, triangle);
    const std::uint8_t bit = side < 0   ? ResolvedFilter::kFront
                             : side > 0 ? ResolvedFilter::kBack
                                        : ResolvedFilter::kEdgeOn;
    return (counting_sides(scene_.scene(), *resolved_, id) & bit) != 0;
  }

  const SceneView& scene_;
  const Ray ray_;
  const ResolvedFilter* const resolved_;
  const std::size_t most_;
  double best_ = std::numeric_limits<double>::infinity();
  Explanation result_;
};

}  // namespace

Explanation explain_ray(const SceneView& scene, const Ray& ray, const ResolvedFilter* resolved,
                        std::size_t most) {
  return Walk(scene, ray, resolved, most).run();
}

}  // namespace sightline
