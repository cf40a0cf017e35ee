// Compiled once per instruction set by Highway; the scalar stages (ray_setup, decision) are shared.

#include "core/trace/kernel.h"

#include <bit>
#include <cmath>
#include <limits>

#include "core/geometry/rounding.h"

// Three x86 levels are worth their code: SSSE3 adds nothing to SSE4 here.
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/trace/kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// a unless it is NaN or smaller: NaN says nothing about a slab.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V max_unless_nan(D, V a, V b) {
#if HWY_ARCH_X86
  return hn::Max(a, b);  // maxps(a, b) is b if either is NaN
#else
  return hn::IfThenElse(hn::Gt(a, b), a, b);
#endif
}
template <class D, class V = hn::Vec<D>>
HWY_INLINE V min_unless_nan(D, V a, V b) {
#if HWY_ARCH_X86
  return hn::Min(a, b);
#else
  return hn::IfThenElse(hn::Lt(a, b), a, b);
#endif
}

template <class D, class M>
HWY_INLINE std::uint32_t mask_bits(D d, M mask) {
  HWY_ALIGN std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  return bits[0];
}

/// Seven siblings may wait on each level of two trees of at most ~130 levels each.
constexpr std::size_t kStack = 2048;

struct Stack {
  HWY_ALIGN std::uint32_t ref[kStack];
  HWY_ALIGN float near[kStack];
};

/// Pushes the children of a node that the ray meets before `limit`, the nearest last.
/// [Kay1986] slabs, conservative as BoxRay says; the order of children is the octant's.
HWY_INLINE std::size_t push_children(const WideNode& node, const BoxRay& ray, float limit,
                                     Stack& stack, std::size_t size) {
  const hn::CappedTag<float, kArity> df;
  const hn::RebindToUnsigned<decltype(df)> du;
  const std::uint32_t o = ray.octant;
  const float* near_plane[3];
  const float* far_plane[3];
  for (std::uint32_t k = 0; k < 3; ++k) {
    const bool negative = (o >> k & 1u) != 0;
    near_plane[k] = negative ? node.upper[k] : node.lower[k];
    far_plane[k] = negative ? node.lower[k] : node.upper[k];
  }
  const auto slab_near = [&](std::size_t i) {
    auto near = hn::Set(df, ray.tau_min);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto plane = hn::Load(df, near_plane[k] + i);
      near = max_unless_nan(df,
                            hn::Mul(hn::Sub(plane, hn::Set(df, ray.near_origin[k])),
                                    hn::Set(df, ray.near_inverse[k])),
                            near);
    }
    return near;
  };
  const auto slab_far = [&](std::size_t i) {
    auto far = hn::Set(df, limit);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto plane = hn::Load(df, far_plane[k] + i);
      far = min_unless_nan(
          df,
          hn::Mul(hn::Sub(plane, hn::Set(df, ray.far_origin[k])), hn::Set(df, ray.far_inverse[k])),
          far);
    }
    return far;
  };
#if HWY_MAX_BYTES >= 32
  const auto near = slab_near(0);
  const auto far = slab_far(0);
  // The permutation is eight fields of three bits; table lookups look at the low three bits only.
  const auto rank =
      hn::And(hn::Shr(hn::Set(du, node.order[o]), hn::Mul(hn::Iota(du, 0), hn::Set(du, 3))),
              hn::Set(du, 7));
  const auto index = hn::IndicesFromVec(df, rank);
  const auto near_sorted = hn::TableLookupLanes(near, index);
  const auto far_sorted = hn::TableLookupLanes(far, index);
  const auto ref_sorted =
      hn::TableLookupLanes(hn::Load(du, node.child), hn::IndicesFromVec(du, rank));
  const auto hit = hn::Le(near_sorted, far_sorted);
  const std::size_t count = hn::CompressStore(near_sorted, hit, df, stack.near + size);
  hn::CompressStore(ref_sorted, hn::RebindMask(du, hit), du, stack.ref + size);
  return size + count;
#else
  HWY_ALIGN float near[kArity];
  HWY_ALIGN float far[kArity];
  (void)du;
  for (std::size_t i = 0; i < kArity; i += hn::Lanes(df)) {
    hn::Store(slab_near(i), df, near + i);
    hn::Store(slab_far(i), df, far + i);
  }
  std::uint32_t order = node.order[o];
  for (std::size_t i = 0; i < kArity; ++i, order >>= 3) {
    const std::uint32_t child = order & 7u;
    stack.ref[size] = node.child[child];
    stack.near[size] = near[child];
    size += near[child] <= far[child] ? 1 : 0;
  }
  return size;
#endif
}

/// Four triangles after the filter: lane i is met for sure (accept), may be met (examine), or is
/// out.
struct LeafVerdict {
  std::uint32_t accept = 0;
  std::uint32_t examine = 0;
  HWY_ALIGN double low[kLanes];
  HWY_ALIGN double high[kLanes];
};

/// The float64 filter of docs/exactness.md, "Triangles": [Woop2013]'s sheared edge functions with a
/// proved bound. Decides nothing that the bound leaves open. `bound` is the ray's best tau so far.
template <bool kPlaced>
HWY_INLINE void filter_block(const LeafBlock& block, const AnchoredRay& ray,
                             const FilterRay& filter, const Placement& placement, double bound,
                             LeafVerdict& verdict) {
  const hn::CappedTag<double, kLanes> dd;
  const hn::Rebind<float, decltype(dd)> df;
  using V = hn::Vec<decltype(dd)>;
  const std::uint32_t kx = filter.kx, ky = filter.ky, kz = filter.kz;
  const V ox = hn::Set(dd, ray.origin[kx]);
  const V oy = hn::Set(dd, ray.origin[ky]);
  const V oz = hn::Set(dd, ray.origin[kz]);
  const V shear_x = hn::Set(dd, filter.shear_x);
  const V shear_y = hn::Set(dd, filter.shear_y);
  const V zero = hn::Zero(dd);

  double edge = static_cast<double>(block.edge_max);
  if constexpr (kPlaced) edge = (edge * placement.edge_scale + placement.edge_pad) * (1 + 0x1p-50);

  verdict.accept = verdict.examine = 0;
  for (std::size_t i = 0; i < kLanes; i += hn::Lanes(dd)) {
    // Corners seen from the origin, sheared so that the ray is the z axis.
    V x[3], y[3], z[3];
    for (std::size_t c = 0; c < 3; ++c) {
      const auto load = [&](std::uint32_t k) {
        return hn::PromoteTo(dd, hn::Load(df, block.corner[c][k] + i));
      };
      V px, py, pz;
      if constexpr (kPlaced) {
        // The contract's own formula: separate products and sums, left to right.
        const V mx = load(0), my = load(1), mz = load(2);
        const auto world = [&](std::uint32_t k) {
          const double* m = placement.world_from_mesh.m[k];
          return hn::Add(
              hn::Add(hn::Add(hn::Mul(hn::Set(dd, m[0]), mx), hn::Mul(hn::Set(dd, m[1]), my)),
                      hn::Mul(hn::Set(dd, m[2]), mz)),
              hn::Set(dd, m[3]));
        };
        px = world(kx);
        py = world(ky);
        pz = world(kz);
      } else {
        px = load(kx);
        py = load(ky);
        pz = load(kz);
      }
      z[c] = hn::Sub(pz, oz);
      x[c] = hn::NegMulAdd(shear_x, z[c], hn::Sub(px, ox));
      y[c] = hn::NegMulAdd(shear_y, z[c], hn::Sub(py, oy));
    }
    const V w0 = hn::MulSub(x[2], y[1], hn::Mul(y[2], x[1]));
    const V w1 = hn::MulSub(x[0], y[2], hn::Mul(y[0], x[2]));
    const V w2 = hn::MulSub(x[1], y[0], hn::Mul(y[1], x[0]));

    // E bounds the error of each w; m bounds every sheared coordinate through corner 0 and the
    // edges.
    const V m =
        hn::Add(hn::Max(hn::Abs(x[0]), hn::Abs(y[0])), hn::Set(dd, 2 * edge + filter.sign_offset));
    const V e = hn::MulAdd(hn::Set(dd, filter.sign_factor), m, hn::Set(dd, kSignFloor));
    const V least = hn::Min(w0, hn::Min(w1, w2));
    const V most = hn::Max(w0, hn::Max(w1, w2));
    const V minus_e = hn::Sub(zero, e);
    const auto out = hn::And(hn::Lt(least, minus_e), hn::Gt(most, e));
    std::uint32_t left = ~mask_bits(dd, out) & ((1u << hn::Lanes(dd)) - 1u);
    if (left == 0) continue;

    const auto in = hn::Or(hn::Gt(least, e), hn::Lt(most, minus_e));
    std::uint32_t certain = mask_bits(dd, in);

    // tau = z on the ray / direction z, as an interval; it holds for uncertain lanes too, if they
    // are met at all.
    const V determinant = hn::Add(hn::Add(w0, w1), w2);
    const V inverse = hn::Div(hn::Set(dd, 1.0), determinant);
    const V sum = hn::MulAdd(w0, z[0], hn::MulAdd(w1, z[1], hn::Mul(w2, z[2])));
    const V tau = hn::Mul(hn::Mul(sum, inverse), hn::Set(dd, filter.inverse_z));
    const V width =
        hn::Mul(hn::MulAdd(hn::Mul(e, hn::Abs(inverse)), hn::Set(dd, 12 * edge + 8 * filter.t_base),
                           hn::Set(dd, filter.t_base)),
                hn::Set(dd, std::abs(filter.inverse_z) * (1 + 0x1p-40)));
    const V low = hn::Sub(tau, width);
    const V high = hn::Add(tau, width);
    hn::Store(low, dd, verdict.low + i);
    hn::Store(high, dd, verdict.high + i);

    // Certainly outside the limits or behind the best: out. Certainly inside the limits: as the
    // signs say. NaN is neither.
    const auto outside =
        hn::Or(hn::Lt(high, hn::Set(dd, ray.tau_min.low)), hn::Gt(low, hn::Set(dd, bound)));
    left &= ~mask_bits(dd, outside);
    const auto inside = hn::And(hn::Ge(low, hn::Set(dd, ray.tau_min.high)),
                                hn::Le(high, hn::Set(dd, ray.tau_max.low)));
    certain &= mask_bits(dd, inside);
    verdict.accept |= (left & certain) << i;
    verdict.examine |= (left & ~certain) << i;
  }
  const std::uint32_t lanes = (1u << block.lane_count) - 1u;
  verdict.accept &= lanes;
  verdict.examine &= lanes;
}

/// What a traversal does with the triangles of a leaf: `Gather` hands them on, `Any` stops
/// at the first.
template <class Decision>
struct Gather {
  Decision& decision;

  double bound() const { return decision.bound(); }
  /// True if the traversal may stop.
  bool take(const LeafBlock& block, std::uint32_t instance, const LeafVerdict& verdict) {
    for (std::uint32_t rest = verdict.accept; rest != 0; rest &= rest - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
      decision.accept({instance, block.triangle[lane]}, {verdict.low[lane], verdict.high[lane]});
    }
    for (std::uint32_t rest = verdict.examine; rest != 0; rest &= rest - 1) {
      decision.examine(
          {instance, block.triangle[static_cast<std::size_t>(std::countr_zero(rest))]});
    }
    return false;
  }
};

struct Any {
  const Scene& scene;
  const Ray& ray;
  double tau_max;
  DecisionCounts& counts;
  bool found = false;

  double bound() const { return tau_max; }
  bool take(const LeafBlock& block, std::uint32_t instance, const LeafVerdict& verdict) {
    found = verdict.accept != 0;
    for (std::uint32_t rest = verdict.examine; rest != 0 && !found; rest &= rest - 1) {
      found = examine_any(
          scene, ray, {instance, block.triangle[static_cast<std::size_t>(std::countr_zero(rest))]},
          counts);
    }
    return found;
  }
};

/// One ray through one tree or, at the top, through the tree over placements.
class Traversal {
 public:
  Traversal(const Scene& scene, const Ray& ray, Stack& stack, TraceCounts& counts)
      : scene_(scene.tree()),
        stack_(stack),
        counts_(counts),
        anchored_(anchor_ray(ray, scene.tree().bounds)),
        filter_(make_filter_ray(anchored_)) {}

  const AnchoredRay& anchored() const { return anchored_; }

  template <class Sink>
  void run(Sink& sink) {
    if (scene_.placements.empty()) return;
    if (scene_.placements.size() == 1) {
      enter(scene_.placements[0], 0, sink);
      return;
    }
    const BoxRay box = make_box_ray(anchored_, scene_.top.scale_exponent);
    walk(scene_.top, box, 0, sink, [&](std::uint32_t ref, std::size_t base) {
      const LeafBlock& block = *scene_.top.blocks(ref);
      for (std::uint32_t i = 0; i < block.lane_count; ++i) {
        if (enter(scene_.placements[block.triangle[i]], base, sink)) return true;
      }
      return false;
    });
  }

 private:
  template <class Sink>
  bool enter(const Placement& placement, std::size_t base, Sink& sink) {
    const WideTree& tree = *scene_.trees[placement.tree];
    const BoxRay box = placement.world_boxes
                           ? make_box_ray(anchored_, tree.scale_exponent)
                           : make_box_ray(anchored_, placement.space, tree.scale_exponent);
    ++counts_.placements;
    const auto blocks = [&]<bool kPlaced>(std::uint32_t ref) {
      LeafVerdict verdict;
      const LeafBlock* block = tree.blocks(ref);
      for (const LeafBlock* end = block + ChildRef::blocks(ref); block != end; ++block) {
        ++counts_.blocks;
        filter_block<kPlaced>(*block, anchored_, filter_, placement, sink.bound(), verdict);
        if ((verdict.accept | verdict.examine) == 0) continue;
        if (sink.take(*block, placement.instance, verdict)) return true;
      }
      return false;
    };
    if (placement.identity) {
      return walk(tree, box, base, sink, [&](std::uint32_t ref, std::size_t) {
        return blocks.template operator()<false>(ref);
      });
    }
    return walk(tree, box, base, sink, [&](std::uint32_t ref, std::size_t) {
      return blocks.template operator()<true>(ref);
    });
  }

  /// Visits the leaves that the ray may meet, roughly front to back, until `leaf` says stop.
  template <class Sink, class Leaf>
  bool walk(const WideTree& tree, const BoxRay& box, std::size_t base, Sink& sink, Leaf leaf) {
    std::size_t size = base;
    stack_.ref[size] = tree.root;
    stack_.near[size++] = box.tau_min;
    float limit = box.limit(sink.bound());
    while (size > base) {
      --size;
      if (!(stack_.near[size] <= limit)) continue;
      const std::uint32_t ref = stack_.ref[size];
      if (ChildRef::is_leaf(ref)) {
        if (leaf(ref, size)) return true;
        limit = box.limit(sink.bound());
      } else {
        ++counts_.nodes;
        size = push_children(tree.node(ref), box, limit, stack_, size);
      }
    }
    return false;
  }

  const SceneTree& scene_;
  Stack& stack_;
  TraceCounts& counts_;
  AnchoredRay anchored_;
  FilterRay filter_;
};

void trace_closest(const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
                   HitBatch& hits, TraceCounts& counts) {
  Stack stack;
  for (std::size_t i = begin; i < end; ++i) {
    const Ray ray = rays[i];
    hits.t[i] = std::numeric_limits<double>::infinity();
    hits.instance[i] = hits.triangle[i] = kNone;
    if (scene.tree().placements.empty()) continue;
    Traversal traversal(scene, ray, stack, counts);
    ClosestDecision decision(scene, ray, traversal.anchored(), counts.decisions);
    Gather<ClosestDecision> sink{decision};
    traversal.run(sink);
    if (!decision.found()) continue;
    hits.t[i] = decision.exact().rounded();
    hits.instance[i] = decision.id().instance;
    hits.triangle[i] = decision.id().triangle;
  }
}

void trace_any(const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
               std::uint8_t* occluded, TraceCounts& counts) {
  Stack stack;
  for (std::size_t i = begin; i < end; ++i) {
    const Ray ray = rays[i];
    occluded[i] = 0;
    if (scene.tree().placements.empty()) continue;
    Traversal traversal(scene, ray, stack, counts);
    Any sink{scene, ray, traversal.anchored().tau_max.high, counts.decisions};
    traversal.run(sink);
    occluded[i] = sink.found ? 1 : 0;
  }
}

void trace_all(const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
               Crossings crossings, std::size_t hits_max, std::uint64_t* totals, HitBatch* hits,
               TraceCounts& counts) {
  Stack stack;
  for (std::size_t i = begin; i < end; ++i) {
    const Ray ray = rays[i];
    totals[i] = 0;
    if (scene.tree().placements.empty()) continue;
    Traversal traversal(scene, ray, stack, counts);
    AllDecision decision(scene, ray, traversal.anchored(), crossings, counts.decisions);
    Gather<AllDecision> sink{decision};
    traversal.run(sink);
    totals[i] = decision.size();
    if (hits != nullptr) decision.append_sorted(hits_max, *hits);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline {

std::vector<Kernel> supported_kernels() {
  std::vector<Kernel> kernels;
  const std::int64_t can = hwy::SupportedTargets();
  const auto add = [&](std::int64_t target, const Kernel& kernel) {
    if ((can & target) != 0) kernels.push_back(kernel);
  };
  // Named one by one, best first, so that a test or a flag can force each of them.
#if HWY_TARGETS & HWY_AVX3
  add(HWY_AVX3, {"avx512", N_AVX3::trace_closest, N_AVX3::trace_any, N_AVX3::trace_all});
#endif
#if HWY_TARGETS & HWY_AVX2
  add(HWY_AVX2, {"avx2", N_AVX2::trace_closest, N_AVX2::trace_any, N_AVX2::trace_all});
#endif
#if HWY_TARGETS & HWY_SSE4
  add(HWY_SSE4, {"sse4", N_SSE4::trace_closest, N_SSE4::trace_any, N_SSE4::trace_all});
#endif
#if HWY_TARGETS & HWY_NEON
  add(HWY_NEON, {"neon", N_NEON::trace_closest, N_NEON::trace_any, N_NEON::trace_all});
#endif
  if (kernels.empty() || HWY_ARCH_X86 != 0) {
    kernels.push_back({"baseline", HWY_NAMESPACE::trace_closest, HWY_NAMESPACE::trace_any,
                       HWY_NAMESPACE::trace_all});
  }
  return kernels;
}

}  // namespace sightline
#endif
