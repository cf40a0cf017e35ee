// Rounds the t of winners, several at a time, in double-double; what that cannot certify is asked
// of the exact predicate. docs/exactness.md, "Rounding t".

#if defined(SIGHTLINE_TRACE_FINISH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_FINISH_INL_H_
#undef SIGHTLINE_TRACE_FINISH_INL_H_
#else
#define SIGHTLINE_TRACE_FINISH_INL_H_
#endif

#include <bit>

#include "core/trace/decision.h"
#include "core/trace/double_double-inl.h"
#include "core/trace/finish_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Winners on their way to their slots; rounded in groups.
class Finisher {
 public:
  static constexpr std::size_t kGroup = 8;
  static constexpr bool kNeighbours = true;  ///< has use for rays that stand side by side

  Finisher(const SceneView& scene, const RayBatch& rays, HitBatch& hits, DecisionCounts& counts)
      : scene_(scene), rays_(rays), hits_(hits), counts_(counts) {
    plain_ = scene.tree().entries == 1 && scene.tree().placements[0].identity;
  }

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

  /// Rounds at once: a request of one ray need not wait for eight.
  void finish(std::size_t ray, const Candidate& winner) {
    const double o[3] = {rays_.ox[ray], rays_.oy[ray], rays_.oz[ray]};
    const double d[3] = {rays_.dx[ray], rays_.dy[ray], rays_.dz[ray]};
    double corner[3][3];
    each_coordinate(winner, [&](int c, int k, double x) { corner[c][k] = x; });
    const RoundedT rounded = round_one(o, d, corner);
    write(ray, winner.id(), rounded.t, rounded.certain);
  }

  /// The winner of those of the kGroup neighbouring rays from `first` on that `some` has a bit for;
  /// false, and nothing done, where the group has more than one origin. Rays of a camera have one,
  /// and many of them meet the same triangle: its plane is looked at once.
  HWY_INLINE bool add_alike(std::size_t first, std::uint32_t some, const Candidate& winner) {
    if (!see_plane(first, winner)) return false;
    const DoubleDouble::D dd;
    std::uint32_t certain = 0;
    for (std::size_t i = 0; i < kGroup; i += hn::Lanes(dd)) {
      const std::size_t at = first + i;
      const MeetingsAtOnce meeting(plane_, {&rays_.dx[at], &rays_.dy[at], &rays_.dz[at]});
      hn::Store(meeting.t.high, dd, t_ + i);
      certain |= mask_bits(dd, meeting.certain()) << i;
    }
    const TriangleId id = winner.id();
    if ((some & certain) == kAll) {
      const hn::CappedTag<std::uint32_t, kGroup> du;
      for (std::size_t i = 0; i < kGroup; i += hn::Lanes(du)) {
        hn::StoreU(hn::Set(du, id.instance), du, &hits_.instance[first + i]);
        hn::StoreU(hn::Set(du, id.triangle), du, &hits_.triangle[first + i]);
      }
      for (std::size_t i = 0; i < kGroup; i += hn::Lanes(dd))
        hn::StoreU(hn::Load(dd, t_ + i), dd, &hits_.t[first + i]);
      return true;
    }
    for (; some != 0; some &= some - 1) {
      const auto i = static_cast<std::uint32_t>(std::countr_zero(some));
      write(first + i, id, t_[i], (certain >> i & 1u) != 0);
    }
    return true;
  }

  /// The winners of kGroup neighbouring rays from `first` on; those that miss have none.
  void add_neighbours(std::size_t first, const Candidate (&winner)[kGroup]) {
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
    // Lanes without a winner repeat some other one's triangle.
    const Candidate* last = nullptr;
    for (std::uint32_t i = 0; i < kGroup; ++i) {
      const Candidate& own = (found >> i & 1u) != 0 ? winner[i] : *some;
      // Neighbours often meet the same triangle, and to place its corners takes time.
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
        write(first + i, neighbours_.id(i), t_[i], (certain >> i & 1u) != 0);
    }
  }

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
      write(ray_[i], waiting_.id(i), t_[i], (certain >> i & 1u) != 0);
    size_ = 0;
  }

 private:
  static constexpr std::uint32_t kAll = (1u << kGroup) - 1;

  struct Winners {
    std::uint32_t instance[kGroup], triangle[kGroup];
    HWY_ALIGN double corner[3][3][kGroup];  ///< in the world

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
  };

  /// Makes plane_ that of a winner and of the one origin of kGroup rays; false where they have
  /// more than one.
  HWY_INLINE bool see_plane(std::size_t first, const Candidate& winner) {
    const DoubleDouble::D dd;
    const double* const origin[3] = {&rays_.ox[first], &rays_.oy[first], &rays_.oz[first]};
    auto same = hn::FirstN(dd, hn::Lanes(dd));
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      const auto one = hn::Set(dd, *origin[k]);
      for (std::size_t i = 0; i < kGroup; i += hn::Lanes(dd))
        same = hn::And(same, hn::Eq(hn::LoadU(dd, origin[k] + i), one));
    }
    if (!hn::AllTrue(dd, same)) return false;
    const bool is_seen = seen_.block == winner.block && seen_.lane == winner.lane &&
                         seen_.instance == winner.instance && seen_from_[0] == *origin[0] &&
                         seen_from_[1] == *origin[1] && seen_from_[2] == *origin[2];
    if (is_seen) return true;
    seen_ = winner;
    HWY_ALIGN double corner[3][3][kGroup];
    each_coordinate(winner,
                    [&](int c, int k, double x) { hn::Store(hn::Set(dd, x), dd, corner[c][k]); });
    MeetingColumns columns{};
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      columns.origin[k] = origin[k];
      seen_from_[k] = *origin[k];
      SIGHTLINE_UNROLL
      for (std::size_t c = 0; c < 3; ++c) columns.corner[c][k] = corner[c][k];
    }
    plane_ = PlanesAtOnce(columns);
    return true;
  }

  /// Lanes without a winner repeat the first one.
  HWY_INLINE void repeat_first(double (&lanes)[kGroup]) const {
    const DoubleDouble::D dd;
    const auto first = hn::Set(dd, lanes[0]);
    for (std::size_t i = 0; i < kGroup; i += hn::Lanes(dd)) {
      const auto kept = hn::FirstN(dd, size_ > i ? size_ - i : 0);
      hn::Store(hn::IfThenElse(kept, hn::Load(dd, lanes + i), first), dd, lanes + i);
    }
  }

  HWY_INLINE void set_corners(const Candidate& winner, std::size_t i, Winners& winners) const {
    winners.instance[i] = winner.instance;
    winners.triangle[i] = winner.block->triangle(winner.lane);
    each_coordinate(winner, [&](int c, int k, double x) { winners.corner[c][k][i] = x; });
  }
  /// Calls use(corner, axis, coordinate in the world).
  template <class Use>
  HWY_INLINE void each_coordinate(const Candidate& winner, const Use& use) const {
    const auto& mesh = winner.block->corner;
    const std::uint32_t lane = winner.lane;
    if (HWY_LIKELY(plain_)) {
      SIGHTLINE_UNROLL
      for (int c = 0; c < 3; ++c) {
        SIGHTLINE_UNROLL
        for (int k = 0; k < 3; ++k) use(c, k, static_cast<double>(mesh[c][k][lane]));
      }
      return;
    }
    const Affine& matrix = scene_.description().instances[winner.instance].world_from_mesh;
    for (int c = 0; c < 3; ++c) {
      const Vec3d corner =
          matrix.apply(Vec3f{mesh[c][0][lane], mesh[c][1][lane], mesh[c][2][lane]});
      for (int k = 0; k < 3; ++k) use(c, k, corner[k]);
    }
  }

  /// Fills t_; bit i: lane i is certainly the nearest float64.
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

  HWY_INLINE void write(std::size_t ray, TriangleId id, double t, bool certain) {
    hits_.instance[ray] = id.instance;
    hits_.triangle[ray] = id.triangle;
    if (HWY_LIKELY(certain)) {
      hits_.t[ray] = t;
    } else {
      ++counts_.exact_roundings;
      hits_.t[ray] = exact_t(scene_.scene(), rays_[ray], id);
    }
  }

  const SceneView& scene_;
  const RayBatch& rays_;
  HitBatch& hits_;
  DecisionCounts& counts_;
  bool plain_;  ///< every placement leaves the corners as they are
  std::size_t size_ = 0;
  std::size_t ray_[kGroup];
  HWY_ALIGN double origin_[3][kGroup];
  HWY_ALIGN double direction_[3][kGroup];
  Winners waiting_, neighbours_;
  Candidate seen_;      ///< no block: nothing is seen yet
  PlanesAtOnce plane_;  ///< of it as seen from seen_from_, in every lane
  double seen_from_[3];
  HWY_ALIGN double t_[kGroup];
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif
