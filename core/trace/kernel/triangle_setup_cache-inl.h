// TriangleSetupCache: caches the planes of triangles that neighbouring rays met. Neighbours often
// meet the same triangles, and of the work to round t, the part for a plane costs more than the
// part for a ray.

#if defined(SIGHTLINE_TRACE_TRIANGLE_SETUP_CACHE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_TRIANGLE_SETUP_CACHE_INL_H_
#undef SIGHTLINE_TRACE_TRIANGLE_SETUP_CACHE_INL_H_
#else
#define SIGHTLINE_TRACE_TRIANGLE_SETUP_CACHE_INL_H_
#endif

#include <bit>

#include "core/trace/kernel/double_double-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// The planes of a few triangles, as many as the widest vector has lanes, each in a slot of the
/// cache, with their distances from one origin. For groups of rays from one point call start_from()
/// once, find() for each group, look() once, and pick() for each vector of rays. New planes are
/// computed several at a time, and each ray uses the plane of its slot. A code is a number that
/// names a triangle (GroupHits).
class TriangleSetupCache {
 public:
  using D = DoubleDouble::D;
  using V = DoubleDouble::V;
  using Slots = hn::RebindToUnsigned<D>;
  static constexpr std::size_t kRays = 8;  ///< rays of a group: elements of the arrays below

  /// Sets the origin of the rays of the following queries. Slots that were used before may be
  /// replaced from now on.
  HWY_INLINE void start_from(const double (&origin)[3]) {
    if (!begun_) begin();
    needed_ = 0;
    const D dd;
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      if (origin_[k][0] == origin[k]) continue;
      stale_ = true;
      for (std::size_t i = 0; i < kSlots; i += hn::Lanes(dd))
        hn::Store(hn::Set(dd, origin[k]), dd, origin_[k] + i);
    }
  }

  /// Finds the slots of the triangles that the rays of the bit set `rays` met: codes[i] is the code
  /// of ray i, slots[i] becomes its slot. A new triangle gets a slot, for which see(code, slot)
  /// must call set_corner for each coordinate and return the triangle's id. Returns false, with
  /// `slots` unusable, if there are not enough slots.
  template <class See>
  HWY_INLINE bool find(const std::uint64_t* codes, std::uint32_t rays, const See& see,
                       std::uint64_t* slots) {
    const Slots du;
    for (std::size_t i = 0; i < kRays; i += hn::Lanes(du)) hn::Store(hn::Zero(du), du, slots + i);
    std::size_t count = 0;
    while (rays != 0) {
      if (++count > kFew) return false;
      const std::uint64_t code = codes[std::countr_zero(rays)];
      std::uint32_t slot = slot_of(code);
      if (slot == kSlots) {
        slot = take_slot(code);
        if (slot == kSlots) return false;
        put(see(code, slot), slot, id_);
      }
      for (std::size_t i = 0; i < kRays; i += hn::Lanes(du)) {
        const auto same = hn::Eq(hn::Load(du, codes + i), hn::Set(du, code));
        const auto others = hn::Load(du, slots + i);
        hn::Store(hn::IfThenElse(same, hn::Set(du, slot), others), du, slots + i);
      }
      rays &= ~lanes_of(codes, code);
    }
    return true;
  }
  /// Sets coordinate k of corner c, in world space, of the triangle in a slot.
  void set_corner(std::uint32_t slot, int c, int k, double coordinate) {
    corner_[c][k][slot] = coordinate;
  }

  /// Computes the planes of new slots. Must be called between find() and pick().
  HWY_INLINE void look() {
    if (stale_) look_again();
  }

  /// The planes of a vector of rays, each from its slot: normal, and SeenFrom::top and top_size.
  struct View {
    NormalOf<D> normal;
    DoubleDouble top;
    V top_size;
  };
  /// The planes in the slots.
  HWY_INLINE View pick(hn::Vec<Slots> slots) const {
    View view;
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      view.normal.n[k] = {pick(high_[k], slots), pick(low_[k], slots)};
      view.normal.size[k] = pick(size_[k], slots);
    }
    view.top = {pick(top_high_, slots), pick(top_low_, slots)};
    view.top_size = pick(top_size_, slots);
    return view;
  }
  /// The ids, as see() returned them, of the triangles in the slots.
  HWY_INLINE hn::Vec<Slots> pick_id(hn::Vec<Slots> slots) const {
    return hn::BitCast(Slots(), pick(reinterpret_cast<const double*>(id_), slots));
  }

  /// Bit i is set if codes[i] equals `code`, for kRays codes.
  static HWY_INLINE std::uint32_t lanes_of(const std::uint64_t* codes, std::uint64_t code) {
    const Slots du;
    std::uint32_t lanes = 0;
    for (std::size_t i = 0; i < kRays; i += hn::Lanes(du))
      lanes |= mask_bits(du, hn::Eq(hn::Load(du, codes + i), hn::Set(du, code))) << i;
    return lanes;
  }

 private:
  static constexpr std::size_t kSlots = 8;

  /// Initialises the cache. Not called by the constructor, because single rays do not use the
  /// cache.
  HWY_NOINLINE void begin() {
    begun_ = true;
    for (std::size_t i = 0; i < kSlots; ++i) {
      code_[i] = id_[i] = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        origin_[k][i] = 0;
        for (auto& corner : corner_) corner[k][i] = 0;
      }
    }
  }
  /// Planes for at most so many triangles of a group are searched code by code.
  static constexpr std::size_t kFew = 4;

  /// The slot of a code; kSlots if it has none.
  HWY_INLINE std::uint32_t slot_of(std::uint64_t code) {
    const std::uint32_t found = lanes_of(code_, code);
    needed_ |= found;
    return found == 0 ? kSlots : static_cast<std::uint32_t>(std::countr_zero(found));
  }
  /// Gives a slot to a code. It replaces a code that no ray has used since start_from; returns
  /// kSlots if there is none.
  std::uint32_t take_slot(std::uint64_t code) {
    const std::uint32_t free = ~needed_ & ((1u << kSlots) - 1);
    if (free == 0) return kSlots;
    // Slots are replaced in turns: a triangle that was met last will be met next.
    const std::uint32_t behind = free & ~((1u << next_) - 1);
    const auto slot = static_cast<std::uint32_t>(std::countr_zero(behind != 0 ? behind : free));
    next_ = (slot + 1) % kSlots;
    needed_ |= 1u << slot;
    put(code, slot, code_);
    stale_ = true;
    return slot;
  }
  static HWY_INLINE V pick(const double* column, hn::Vec<Slots> slots) {
    const D dd;
    if constexpr (hn::MaxLanes(D()) == kSlots) {
      return hn::TableLookupLanes(hn::Load(dd, column), hn::IndicesFromVec(dd, slots));
    } else {
      return hn::GatherIndex(dd, column, hn::BitCast(hn::RebindToSigned<D>(), slots));
    }
  }
  /// Writes whole vectors, because they are read as such immediately afterwards.
  static HWY_INLINE void put(std::uint64_t value, std::uint32_t slot, std::uint64_t* column) {
    const Slots du;
    for (std::size_t i = 0; i < kSlots; i += hn::Lanes(du)) {
      const auto here = hn::Eq(hn::Iota(du, i), hn::Set(du, slot));
      hn::Store(hn::IfThenElse(here, hn::Set(du, value), hn::Load(du, column + i)), du, column + i);
    }
  }

  HWY_NOINLINE void look_again() {
    const D dd;
    stale_ = false;
    for (std::size_t i = 0; i < kSlots; i += hn::Lanes(dd)) {
      const double* corner[3][3];
      const double* origin[3];
      SIGHTLINE_UNROLL
      for (std::size_t k = 0; k < 3; ++k) {
        origin[k] = origin_[k] + i;
        SIGHTLINE_UNROLL
        for (std::size_t c = 0; c < 3; ++c) corner[c][k] = corner_[c][k] + i;
      }
      const EdgesOf<D> edges(corner);
      const NormalOf<D> normal(edges);
      const SeenFrom<D> seen(normal, corner[0], origin);
      SIGHTLINE_UNROLL
      for (std::size_t k = 0; k < 3; ++k) {
        hn::Store(normal.n[k].high, dd, high_[k] + i);
        hn::Store(normal.n[k].low, dd, low_[k] + i);
        hn::Store(normal.size[k], dd, size_[k] + i);
      }
      hn::Store(seen.top.high, dd, top_high_ + i);
      hn::Store(seen.top.low, dd, top_low_ + i);
      hn::Store(seen.top_size, dd, top_size_ + i);
    }
  }

  bool begun_ = false, stale_ = false;
  std::uint32_t needed_ = 0, next_ = 0;
  HWY_ALIGN std::uint64_t code_[kSlots], id_[kSlots];
  HWY_ALIGN double corner_[3][3][kSlots];  ///< in world space
  HWY_ALIGN double origin_[3][kSlots];
  HWY_ALIGN double high_[3][kSlots], low_[3][kSlots], size_[3][kSlots];
  HWY_ALIGN double top_high_[kSlots], top_low_[kSlots], top_size_[kSlots];
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif
