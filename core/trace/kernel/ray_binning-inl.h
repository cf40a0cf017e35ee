// Ray binning: rays that start near each other but diverge are sorted by octant, largest axis and
// origin, so that they can be traced as packets [Garanzha2010]. An example is ambient occlusion in
// a room. Where rays have too little in common, this is slower than interleaved traversal; a trial
// packet decides.

#if defined(SIGHTLINE_TRACE_RAY_BINNING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_RAY_BINNING_INL_H_
#undef SIGHTLINE_TRACE_RAY_BINNING_INL_H_
#else
#define SIGHTLINE_TRACE_RAY_BINNING_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/query/ray_batch.h"
#include "core/trace/kernel/packet-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Traces up to kMost rays of a batch as sorted packets. Ask is_promising() before trace(). A class
/// is the set of rays with one octant and one largest axis of the direction.
template <bool kAny, Layout kLayout>
class RayBins {
 public:
  static constexpr std::size_t kMost = 4096;   ///< rays that are sorted at a time
  static constexpr std::size_t kFewest = 512;  ///< with fewer rays, most packets would be small

  /// `resolved`: which triangles count; null: all. `occluded` is written if kAny, else null. All
  /// arguments must outlive this object.
  RayBins(const SceneView& scene, const RayBatch& rays, std::uint8_t* occluded,
          const ResolvedFilter* resolved, TraceCounts& counts)
      : rays_(rays), occluded_(occluded), packet_(scene, sorted_, found_, resolved, counts) {}

  /// True if sorting is worth a trial: traces some of the kFewest rays from `first` on, which must
  /// exist, and discards the results.
  bool is_promising(std::size_t first) {
    classify(first, kLook);
    std::uint32_t counts[kClasses] = {};
    for (std::size_t i = 0; i < kLook; ++i) ++counts[class_[i]];
    // A scanner's rays change the octant rarely; between changes they need no sorting.
    std::size_t turns = 0;
    for (std::size_t i = 1; i < kLook; ++i) turns += class_[i] != class_[i - 1] ? 1 : 0;
    if (turns < kLook / kLongRun) return false;
    // Tries the classes of two rays: rays into the sky alone would always be promising.
    return does_try_pay(first, counts, class_[kLook / 3]) &&
           does_try_pay(first, counts, class_[kLook - 1]);
  }

  /// Sorts and traces `count` rays from `first` on, at least kFewest and at most kMost. Calls
  /// finish.add(ray, candidate) for closest hits, or sets occluded[ray] if kAny. Calls alone(ray)
  /// for rays that are in no packet: they are not traced. Returns false if interleaved traversal
  /// would have been faster.
  template <class Finish, class Alone>
  bool trace(std::size_t first, std::size_t count, Finish& finish, const Alone& alone) {
    classify(first, count);
    divide(first, count);
    std::uint32_t begin[kClasses * kCells] = {};
    for (std::size_t i = 0; i < count; ++i) ++begin[class_[i]];
    std::uint32_t sum = 0;
    for (std::uint32_t& entry : begin) sum += std::exchange(entry, sum);
    for (std::size_t i = 0; i < count; ++i)
      order_[begin[class_[i]]++] = static_cast<std::uint32_t>(i);
    copy(first, count);
    const InOrder<Finish> in_order{finish, order_, first};
    std::uint64_t steps = 0, ray_steps = 0;
    for (std::size_t i = 0; i < count;) {
      const std::size_t together = packet_.prepare(i, std::min(count - i, kPacketRays));
      if (together < kFewestRays) {
        for (const std::size_t end = i + std::max<std::size_t>(together, 1); i < end; ++i)
          alone(first + order_[i]);
        continue;
      }
      packet_.trace(in_order);
      steps += packet_.steps();
      ray_steps += packet_.ray_steps();
      if constexpr (kAny) {
        for (std::size_t k = i; k < i + together; ++k) occluded_[first + order_[k]] = found_[k];
      }
      i += together;
    }
    return thresholds::kFewestPerStepIfSorted * static_cast<double>(steps) <
           static_cast<double>(ray_steps);
  }

 private:
  static constexpr std::size_t kClasses = 24;
  static constexpr int kCells = 8;             ///< parts of a class, by the rays' origins
  static constexpr std::size_t kLook = 256;    ///< rays from which those of a trial are chosen
  static constexpr std::size_t kLongRun = 16;  ///< mean length of runs of one class

  bool does_try_pay(std::size_t first, const std::uint32_t (&counts)[kClasses],
                    std::uint8_t wanted) {
    // If most rays are similar, they need no sorting.
    if (counts[wanted] < kNarrowRays / 2 || counts[wanted] > kLook / 2) return false;
    std::size_t count = 0;
    for (std::size_t i = 0; i < kLook && count < kNarrowRays; ++i) {
      if (class_[i] == wanted) order_[count++] = static_cast<std::uint32_t>(i);
    }
    copy(first, count);
    return packet_.prepare(0, count) == count && packet_.try_out(thresholds::kFewestToBeginSorting);
  }

  /// Passes hits on, with the index of the ray in the batch instead of its position in sorted
  /// order.
  template <class Finish>
  struct InOrder {
    Finish& finish;
    const std::uint32_t* order;
    std::size_t first;

    void add(std::size_t i, const Candidate& winner) const { finish.add(first + order[i], winner); }
  };

  /// Sets class_ for `count` rays, by octant and largest axis of the direction.
  void classify(std::size_t first, std::size_t count) {
    const D dd;
    const hn::RebindToUnsigned<D> du;
    std::size_t i = 0;
    for (; i + hn::Lanes(dd) <= count; i += hn::Lanes(dd)) {
      if (i % 8 == 0) {  // `copy` reads these columns in an order that the processor cannot predict
        for (const auto* column : {&rays_.ox, &rays_.oy, &rays_.oz, &rays_.tmin, &rays_.tmax})
          hwy::Prefetch(column->data() + first + i);
      }
      const auto x = hn::LoadU(dd, &rays_.dx[first + i]), y = hn::LoadU(dd, &rays_.dy[first + i]),
                 z = hn::LoadU(dd, &rays_.dz[first + i]);
      const auto ax = hn::Abs(x), ay = hn::Abs(y), az = hn::Abs(z);
      const auto is_x = hn::And(hn::Ge(ax, ay), hn::Ge(ax, az));
      const auto is_y = hn::And(hn::Gt(ay, ax), hn::Ge(ay, az));
      const auto sign = [&](auto v) { return hn::ShiftRight<63>(hn::BitCast(du, v)); };
      const auto octant =
          hn::Or(sign(x), hn::Or(hn::ShiftLeft<1>(sign(y)), hn::ShiftLeft<2>(sign(z))));
      const auto axis =
          hn::IfThenElse(hn::RebindMask(du, is_x), hn::Set(du, 1),
                         hn::IfThenElseZero(hn::RebindMask(du, is_y), hn::Set(du, 2)));
      store_bytes(hn::Add(hn::Add(octant, hn::ShiftLeft<1>(octant)), axis), class_ + i);
    }
    for (; i < count; ++i) class_[i] = class_of(first + i);
  }
  std::uint8_t class_of(std::size_t ray) const {
    const double x = rays_.dx[ray], y = rays_.dy[ray], z = rays_.dz[ray];
    const double ax = std::abs(x), ay = std::abs(y), az = std::abs(z);
    const int axis = ax >= ay && ax >= az ? 1 : ay > ax && ay >= az ? 2 : 0;
    const int octant =
        (std::signbit(x) ? 1 : 0) | (std::signbit(y) ? 2 : 0) | (std::signbit(z) ? 4 : 0);
    return static_cast<std::uint8_t>(3 * octant + axis);
  }

  /// Divides the classes into cells along the axis on which the origins differ most.
  void divide(std::size_t first, std::size_t count) {
    const D dd;
    const double* widest = nullptr;
    double least = 0, extent = 0;
    for (const auto* column : {&rays_.ox, &rays_.oy, &rays_.oz}) {
      const double* values = column->data() + first;
      auto low = hn::LoadU(dd, values), high = low;
      // Cells only affect the order, so the last few rays may be outside of the range.
      for (std::size_t i = hn::Lanes(dd); i + hn::Lanes(dd) <= count; i += hn::Lanes(dd)) {
        low = hn::Min(low, hn::LoadU(dd, values + i));
        high = hn::Max(high, hn::LoadU(dd, values + i));
      }
      const double from = hn::GetLane(hn::MinOfLanes(dd, low));
      const double wide = hn::GetLane(hn::MaxOfLanes(dd, high)) - from;
      if (widest != nullptr && !(wide > extent)) continue;
      widest = values;
      least = from;
      extent = wide;
    }
    // No cells if numbers may overflow.
    const bool divides = extent > 0x1p-1000 && extent < 0x1p1000;
    const double cells = divides ? kCells / extent : 0;
    const hn::RebindToSigned<D> di;
    const hn::RebindToUnsigned<D> du;
    std::size_t i = 0;
    for (; divides && i + hn::Lanes(dd) <= count; i += hn::Lanes(dd)) {
      const auto at =
          hn::Mul(hn::Sub(hn::LoadU(dd, widest + i), hn::Set(dd, least)), hn::Set(dd, cells));
      const auto cell = hn::ConvertTo(di, hn::Min(at, hn::Set(dd, kCells - 1)));
      store_bytes(hn::BitCast(du, cell), cell_ + i);
    }
    for (; i < count; ++i) cell_[i] = 0;
    for (i = 0; i < count; ++i)
      class_[i] = static_cast<std::uint8_t>(kCells * class_[i] + cell_[i]);
  }

  using D = hn::CappedTag<double, 8>;
  /// Stores the lowest byte of each lane.
  static HWY_INLINE void store_bytes(hn::Vec<hn::RebindToUnsigned<D>> lanes, std::uint8_t* to) {
    const hn::Rebind<std::uint8_t, D> d8;
    hn::StoreU(hn::TruncateTo(d8, lanes), d8, to);
  }

  void copy(std::size_t first, std::size_t count) {
    sorted_.resize(std::max(sorted_.size(), count + kPacketRays));
    for (const auto& [to, from] : {std::pair{&sorted_.ox, &rays_.ox},
                                   {&sorted_.oy, &rays_.oy},
                                   {&sorted_.oz, &rays_.oz},
                                   {&sorted_.dx, &rays_.dx},
                                   {&sorted_.dy, &rays_.dy},
                                   {&sorted_.dz, &rays_.dz},
                                   {&sorted_.tmin, &rays_.tmin},
                                   {&sorted_.tmax, &rays_.tmax}}) {
      double* HWY_RESTRICT out = to->data();
      const double* HWY_RESTRICT in = from->data() + first;
      for (std::size_t i = 0; i < count; ++i) out[i] = in[order_[i]];
    }
    if (rays_.mask.empty()) return;
    sorted_.mask.resize(sorted_.size());
    for (std::size_t i = 0; i < count; ++i) sorted_.mask[i] = rays_.mask[first + order_[i]];
  }

  const RayBatch& rays_;
  std::uint8_t* occluded_;
  RayBatch sorted_;
  std::uint32_t order_[kMost];  ///< sorted position i is ray order_[i] of those sorted
  std::uint8_t class_[kMost], cell_[kMost];
  std::uint8_t found_[kMost + kPacketRays];
  Packet<kAny, kLayout> packet_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
