// Rounds the t of closest hits, several at a time, in double-double. If its error bound does not
// suffice, the exact predicate rounds t. docs/explanation/exactness.md, "Rounding t".

#if defined(SIGHTLINE_TRACE_ROUND_T_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_ROUND_T_INL_H_
#undef SIGHTLINE_TRACE_ROUND_T_INL_H_
#else
#define SIGHTLINE_TRACE_ROUND_T_INL_H_
#endif

#include <bit>

#include "core/trace/decision.h"
#include "core/trace/kernel/double_double-inl.h"
#include "core/trace/kernel/round_one_t-inl.h"
#include "core/trace/kernel/triangle_setup_cache-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Rounds the t of the closest hit of a single ray, and writes the hit to the slot of the ray.
HWY_INLINE void write_hit(const SceneView& scene, const RayBatch& rays, std::size_t ray,
                          const Candidate& winner, HitBatch& hits, DecisionCounts& counts) {
  const double o[3] = {rays.ox[ray], rays.oy[ray], rays.oz[ray]};
  const double d[3] = {rays.dx[ray], rays.dy[ray], rays.dz[ray]};
  const bool plain = scene.tree().entries == 1 && scene.tree().placements[0].identity;
  const Affine* matrix =
      plain ? nullptr : &scene.description().instances[winner.instance].world_from_mesh;
  const RoundedT rounded = round_one(o, d, WorldCorners(*winner.block, winner.lane, matrix));
  const TriangleId id = winner.id();
  hits.instance[ray] = id.instance;
  hits.triangle[ray] = id.triangle;
  if (HWY_LIKELY(rounded.certain)) {
    hits.t[ray] = rounded.t;
  } else {
    ++counts.exact_roundings;
    hits.t[ray] = exact_t(scene.scene(), rays[ray], id);
  }
}

/// Collects closest hits and writes them to the slots of a batch; rounds t in groups. Call add() or
/// add_neighbours(), then flush(). The arguments of the constructor must outlive it.
class TRounding {
 public:
  static constexpr std::size_t kGroup = 8;   ///< hits that are rounded at a time
  static constexpr bool kNeighbours = true;  ///< neighbouring rays are passed in one call

  TRounding(const SceneView& scene, const RayBatch& rays, HitBatch& hits, DecisionCounts& counts)
      : scene_(scene), rays_(rays), hits_(hits), counts_(counts) {
    plain_ = scene.tree().entries == 1 && scene.tree().placements[0].identity;
  }

  /// Adds the closest hit of a ray of the batch; writes it when kGroup hits are collected.
  void add(std::size_t ray, const Candidate& winner) {
    ray_[size_] = ray;
    set_corners(winner, size_, waiting_);
    const double o[3] = {rays_.ox[ray], rays_.oy[ray], rays_.oz[ray]};
    const double d[3] = {rays_.dx[ray], rays_.dy[ray], rays_.dz[ray]};
    SIGHTLINE_UNROLL
    for (int k = 0; k < 3; ++k) {
      origin_[k][size_] = o[k];
      direction_[k][size_] = d[k];
    }
    if (++size_ == kGroup) flush();
  }

  /// Writes the hits of add() that remain.
  void flush() {
    if (size_ == 0) return;
    const double* origin[3] = {origin_[0], origin_[1], origin_[2]};
    const double* direction[3] = {direction_[0], direction_[1], direction_[2]};
    SIGHTLINE_UNROLL
    for (int k = 0; k < 3; ++k) {
      repeat_first(origin_[k]);
      repeat_first(direction_[k]);
      SIGHTLINE_UNROLL
      for (int c = 0; c < 3; ++c) repeat_first(waiting_.corner[c][k]);
    }
    const std::uint32_t certain = round(origin, direction, waiting_);
    for (std::size_t i = 0; i < size_; ++i)
      write(ray_[i], waiting_.id(i), t_[i], (certain >> i & 1u) != 0,
            [&] { return exact_t(rays_[ray_[i]], waiting_.triangle_of(i)); });
    size_ = 0;
  }

  /// Adds the closest hits of `count` neighbouring rays from `first` on. codes[i] is 0 for a miss,
  /// and equal codes are one triangle, which winner(code) returns. Misses are not written.
  /// Preconditions: count is at most kMostNeighbours. Rays and codes exist up to the next multiple
  /// of kGroup.
  template <class Winner>
  HWY_INLINE void add_neighbours(std::size_t first, std::size_t count, const std::uint64_t* codes,
                                 const Winner& winner) {
    const bool one_origin = look_from_one_origin(first, count);
    const auto see = [&](std::uint64_t code, std::uint32_t slot) {
      const Candidate seen = winner(code);
      each_coordinate(seen, [&](int c, int k, double x) { planes_.set_corner(slot, c, k, x); });
      const TriangleId id = seen.id();
      return std::uint64_t{id.triangle} << 32 | id.instance;
    };
    HWY_ALIGN std::uint64_t slots[kMostNeighbours];
    std::uint32_t some_seen[kMostNeighbours / kGroup];
    for (std::size_t at = 0; at < count; at += kGroup) {
      const std::uint32_t here = at + kGroup <= count ? kAll : (1u << (count - at)) - 1;
      const std::uint32_t found = here & ~TriangleSetupCache::lanes_of(codes + at, 0);
      const bool are_seen = one_origin && planes_.find(codes + at, found, see, slots + at);
      some_seen[at / kGroup] = are_seen ? found : 0;
      if (are_seen) continue;
      Candidate winners[kGroup];
      for (std::uint32_t rest = found; rest != 0; rest &= rest - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(rest));
        winners[i] = winner(codes[at + i]);
      }
      add_group(first + at, winners);
    }
    if (!one_origin) return;
    planes_.look();
    for (std::size_t at = 0; at < count; at += kGroup) {
      const std::uint32_t some = some_seen[at / kGroup];
      if (some != 0) add_seen(first + at, some, slots + at);
    }
  }

 private:
  static constexpr std::uint32_t kAll = (1u << kGroup) - 1;
  static constexpr std::size_t kMostNeighbours = 64;
  static_assert(kGroup == TriangleSetupCache::kRays);

  /// True if these rays start at one point; then planes_ is set up for that point.
  HWY_INLINE bool look_from_one_origin(std::size_t first, std::size_t count) {
    const DoubleDouble::D dd;
    const double origin[3] = {rays_.ox[first], rays_.oy[first], rays_.oz[first]};
    const double* const columns[3] = {&rays_.ox[first], &rays_.oy[first], &rays_.oz[first]};
    auto same = hn::FirstN(dd, hn::Lanes(dd));
    for (std::size_t i = 0; i < count; i += hn::Lanes(dd)) {
      SIGHTLINE_UNROLL
      for (std::size_t k = 0; k < 3; ++k) {
        same = hn::And(same, hn::Eq(hn::LoadU(dd, columns[k] + i), hn::Set(dd, origin[k])));
      }
    }
    if (!hn::AllTrue(dd, same)) return false;
    planes_.start_from(origin);
    return true;
  }

  /// Adds those rays of a group whose planes have slots in planes_.
  HWY_INLINE void add_seen(std::size_t first, std::uint32_t some, const std::uint64_t* slots) {
    const TriangleSetupCache::D dd;
    const TriangleSetupCache::Slots du;
    const hn::Rebind<std::uint32_t, TriangleSetupCache::D> d32;
    HWY_ALIGN std::uint32_t instance[kGroup], triangle[kGroup];
    std::uint32_t certain = 0;
    for (std::size_t i = 0; i < kGroup; i += hn::Lanes(dd)) {
      const std::size_t at = first + i;
      const auto slot = hn::Load(du, slots + i);
      const TriangleSetupCache::View plane = planes_.pick(slot);
      const MeetingOf<TriangleSetupCache::D> meeting(plane.normal, plane.top, plane.top_size,
                                                     {&rays_.dx[at], &rays_.dy[at], &rays_.dz[at]});
      const auto id = planes_.pick_id(slot);
      hn::Store(meeting.t.high, dd, t_ + i);
      hn::Store(hn::TruncateTo(d32, id), d32, instance + i);
      hn::Store(hn::TruncateTo(d32, hn::ShiftRight<32>(id)), d32, triangle + i);
      certain |= mask_bits(dd, meeting.certain()) << i;
    }
    if ((some & certain) == kAll) {
      for (std::size_t i = 0; i < kGroup; i += hn::Lanes(dd)) {
        hn::StoreU(hn::Load(d32, instance + i), d32, &hits_.instance[first + i]);
        hn::StoreU(hn::Load(d32, triangle + i), d32, &hits_.triangle[first + i]);
        hn::StoreU(hn::Load(dd, t_ + i), dd, &hits_.t[first + i]);
      }
      return;
    }
    for (; some != 0; some &= some - 1) {
      const auto i = static_cast<std::uint32_t>(std::countr_zero(some));
      const TriangleId id{instance[i], triangle[i]};
      write(first + i, id, t_[i], (certain >> i & 1u) != 0,
            [&] { return exact_t(scene_.scene(), rays_[first + i], id); });
    }
  }

  /// Adds the closest hits of kGroup neighbouring rays from `first` on; a miss has no block.
  void add_group(std::size_t first, const Candidate (&winner)[kGroup]) {
    const Candidate* some = nullptr;
    std::uint32_t found = 0;
    for (std::uint32_t i = 0; i < kGroup; ++i) {
      if (winner[i].block == nullptr) continue;
      some = &winner[i];
      found |= 1u << i;
    }
    if (std::popcount(found) <= static_cast<int>(kGroup / 2)) {
      for (std::uint32_t i = 0; i < kGroup; ++i) {
        if ((found >> i & 1u) != 0) add(first + i, winner[i]);
      }
      return;
    }
    // Lanes without a hit repeat the triangle of another lane.
    const Candidate* last = nullptr;
    for (std::uint32_t i = 0; i < kGroup; ++i) {
      const Candidate& own = (found >> i & 1u) != 0 ? winner[i] : *some;
      // Neighbours often meet one triangle, and mapping its corners to world space takes time.
      if (!plain_ && last != nullptr && own.block == last->block && own.lane == last->lane &&
          own.instance == last->instance) {
        neighbours_.repeat(i - 1, i);
      } else {
        set_corners(own, i, neighbours_);
      }
      last = &own;
    }
    const double* origin[3] = {&rays_.ox[first], &rays_.oy[first], &rays_.oz[first]};
    const double* direction[3] = {&rays_.dx[first], &rays_.dy[first], &rays_.dz[first]};
    const std::uint32_t certain = round(origin, direction, neighbours_);
    for (std::uint32_t i = 0; i < kGroup; ++i) {
      if ((found >> i & 1u) != 0)
        write(first + i, neighbours_.id(i), t_[i], (certain >> i & 1u) != 0,
              [&] { return exact_t(rays_[first + i], neighbours_.triangle_of(i)); });
    }
  }

  struct Winners {
    std::uint32_t instance[kGroup], triangle[kGroup];
    HWY_ALIGN double corner[3][3][kGroup];  ///< in world space

    HWY_INLINE void repeat(std::size_t from, std::size_t to) {
      instance[to] = instance[from];
      triangle[to] = triangle[from];
      SIGHTLINE_UNROLL
      for (int c = 0; c < 3; ++c) {
        SIGHTLINE_UNROLL
        for (int k = 0; k < 3; ++k) corner[c][k][to] = corner[c][k][from];
      }
    }
    TriangleId id(std::size_t i) const { return {instance[i], triangle[i]}; }
    Triangle triangle_of(std::size_t i) const {
      const auto at = [&](int c) {
        return Vec3d{corner[c][0][i], corner[c][1][i], corner[c][2][i]};
      };
      return {at(0), at(1), at(2)};
    }
  };

  /// Lanes without a hit repeat the first lane.
  HWY_INLINE void repeat_first(double (&lanes)[kGroup]) const {
    const DoubleDouble::D dd;
    const auto first = hn::Set(dd, lanes[0]);
    for (std::size_t i = 0; i < kGroup; i += hn::Lanes(dd)) {
      const auto resolved = hn::FirstN(dd, size_ > i ? size_ - i : 0);
      hn::Store(hn::IfThenElse(resolved, hn::Load(dd, lanes + i), first), dd, lanes + i);
    }
  }

  HWY_INLINE void set_corners(const Candidate& winner, std::size_t i, Winners& winners) const {
    winners.instance[i] = winner.instance;
    winners.triangle[i] = winner.block->triangle(winner.lane);
    each_coordinate(winner, [&](int c, int k, double x) { winners.corner[c][k][i] = x; });
  }
  /// Calls use(corner, axis, world coordinate) for each coordinate of a triangle.
  template <class Use>
  HWY_INLINE void each_coordinate(const Candidate& winner, const Use& use) const {
    const Affine& matrix = scene_.description().instances[winner.instance].world_from_mesh;
    SIGHTLINE_UNROLL
    for (int c = 0; c < 3; ++c) {
      const Vec3f mesh = winner.block->corner(static_cast<std::size_t>(c), winner.lane);
      if (HWY_LIKELY(plain_)) {
        SIGHTLINE_UNROLL
        for (int k = 0; k < 3; ++k) use(c, k, static_cast<double>(mesh[k]));
      } else {
        const Vec3d corner = matrix.apply(mesh);
        for (int k = 0; k < 3; ++k) use(c, k, corner[k]);
      }
    }
  }

  /// Sets t_. Bit i of the result: lane i is certainly the nearest float64.
  HWY_INLINE std::uint32_t round(const double* const (&origin)[3],
                                 const double* const (&direction)[3], const Winners& winners) {
    const DoubleDouble::D dd;
    std::uint32_t certain = 0;
    for (std::size_t i = 0; i < kGroup; i += hn::Lanes(dd)) {
      MeetingColumns columns;
      SIGHTLINE_UNROLL
      for (std::size_t k = 0; k < 3; ++k) {
        columns.origin[k] = origin[k] + i;
        columns.direction[k] = direction[k] + i;
        SIGHTLINE_UNROLL
        for (std::size_t c = 0; c < 3; ++c) columns.corner[c][k] = winners.corner[c][k] + i;
      }
      const Intersection meeting(columns);
      hn::Store(meeting.t.high, dd, t_ + i);
      certain |= mask_bits(dd, meeting.certain()) << i;
    }
    return certain;
  }

  /// exact() is t, rounded from the exact number.
  template <class Exact>
  HWY_INLINE void write(std::size_t ray, TriangleId id, double t, bool certain,
                        const Exact& exact) {
    hits_.instance[ray] = id.instance;
    hits_.triangle[ray] = id.triangle;
    if (HWY_LIKELY(certain)) {
      hits_.t[ray] = t;
    } else {
      ++counts_.exact_roundings;
      hits_.t[ray] = exact();
    }
  }

  const SceneView& scene_;
  const RayBatch& rays_;
  HitBatch& hits_;
  DecisionCounts& counts_;
  bool plain_;  ///< no placement changes the corners
  std::size_t size_ = 0;
  std::size_t ray_[kGroup];
  HWY_ALIGN double origin_[3][kGroup];
  HWY_ALIGN double direction_[3][kGroup];
  Winners waiting_, neighbours_;
  TriangleSetupCache planes_;
  HWY_ALIGN double t_[kGroup];
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
