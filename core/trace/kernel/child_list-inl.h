// ChildList: lists the children of a node that a ray or a packet meets, in the order of the visit.
// A slot is the index of a child in its WideNode. The eight results of the box tests are compressed
// in registers, without a branch:
//
//   AVX-512         the compress instruction
//   AVX2            a permutation of eight lanes from kCompress
//   SSE4, NEON      a shuffle of eight bytes from kCompress, each of which then moves four bytes
//   other targets   one child after the other

#if defined(SIGHTLINE_TRACE_CHILD_LIST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_CHILD_LIST_INL_H_
#undef SIGHTLINE_TRACE_CHILD_LIST_INL_H_
#else
#define SIGHTLINE_TRACE_CHILD_LIST_INL_H_
#endif

#include <bit>

#include "core/trace/kernel/child_slots-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

#if SIGHTLINE_NATIVE_COMPRESS

/// The children of a node, and which of them a ray meets. Construct it from the box tests, call
/// sort() if the order matters, then store(). Position i is child i of the WideNode, or after
/// sort() the i-th in the order far to near. Node and boxes must outlive it. Each instruction set
/// has one of these classes.
class ChildList {
 public:
  HWY_INLINE ChildList(const WideNode& node, const BoxCrossings& boxes)
      : near_(boxes.near[0]), far_(boxes.far[0]), child_(hn::Load(RefLanes(), node.child)) {}

  /// Sorts by the node's order for rays of an octant, from far to near.
  HWY_INLINE void sort(const WideNode& node, std::uint32_t octant) {
    slot_ = child_order(node, octant);
    const auto index = hn::IndicesFromVec(BoxLanes(), slot_);
    near_ = hn::TableLookupLanes(near_, index);
    far_ = hn::TableLookupLanes(far_, index);
    child_ = hn::TableLookupLanes(child_, hn::IndicesFromVec(RefLanes(), slot_));
  }
  /// Bit i: the ray meets the box of the child at position i.
  HWY_INLINE std::uint32_t bits() const { return mask_bits(BoxLanes(), met()); }

  /// Writes references and entry distances of the children that are met, in the order of positions.
  /// Returns their number. Eight elements of both arrays may be overwritten.
  HWY_INLINE std::size_t store(std::uint32_t* HWY_RESTRICT ref_out,
                               float* HWY_RESTRICT near_out) const {
    store(met(), child_, ref_out, near_out);
    return hn::CountTrue(BoxLanes(), met());
  }
  /// store() without entry distances.
  HWY_INLINE std::size_t store(std::uint32_t* HWY_RESTRICT ref_out) const {
    hn::StoreU(hn::Compress(child_, hn::RebindMask(RefLanes(), met())), RefLanes(), ref_out);
    return hn::CountTrue(BoxLanes(), met());
  }
  /// store() with slots instead of references. Precondition: sort() was called.
  HWY_INLINE std::size_t store_slots(std::uint32_t* HWY_RESTRICT slot_out,
                                     float* HWY_RESTRICT near_out) const {
    store(met(), slot_, slot_out, near_out);
    return hn::CountTrue(BoxLanes(), met());
  }
  /// Writes the children at the positions whose bit is set.
  HWY_INLINE void store(std::uint32_t bits, std::uint32_t* HWY_RESTRICT ref_out,
                        float* HWY_RESTRICT near_out) const {
    const auto some = static_cast<std::uint8_t>(bits);
    store(hn::LoadMaskBits(BoxLanes(), &some), child_, ref_out, near_out);
  }

 private:
  HWY_INLINE hn::Mask<BoxLanes> met() const { return hn::Le(near_, far_); }
  HWY_INLINE void store(hn::Mask<BoxLanes> some, hn::Vec<RefLanes> numbers,
                        std::uint32_t* HWY_RESTRICT out, float* HWY_RESTRICT near_out) const {
    // Compressed in registers: a compressing store would delay the next pop.
    hn::StoreU(hn::Compress(near_, some), BoxLanes(), near_out);
    hn::StoreU(hn::Compress(numbers, hn::RebindMask(RefLanes(), some)), RefLanes(), out);
  }

  hn::Vec<BoxLanes> near_, far_;
  hn::Vec<RefLanes> child_, slot_;
};

#elif SIGHTLINE_TABLE_COMPRESS
/// The children of a node, and which of them a ray meets. Construct it from the box tests, call
/// sort() if the order matters, then store(). Position i is child i of the WideNode, or after
/// sort() the i-th in the order far to near. Node and boxes must outlive it. Each instruction set
/// has one of these classes.
class ChildList {
 public:
  HWY_INLINE ChildList(const WideNode& node, const BoxCrossings& boxes)
      : node_(node), boxes_(boxes), met_(ChildSlots::met(boxes)) {}

  /// Sorts by the node's order for rays of an octant, from far to near.
  HWY_INLINE void sort(const WideNode& node, std::uint32_t octant) {
    order_ = ChildSlots::order(node, octant);
    met_ = ChildSlots::shuffle(met_, order_);
    sorted_ = true;
  }
  /// Bit i: the ray meets the box of the child at position i.
  HWY_INLINE std::uint32_t bits() const { return ChildSlots::bits(met_); }

  /// Writes references and entry distances of the children that are met, in the order of positions.
  /// Returns their number. Eight elements of both arrays may be overwritten.
  HWY_INLINE std::size_t store(std::uint32_t* HWY_RESTRICT ref_out,
                               float* HWY_RESTRICT near_out) const {
    const std::uint32_t all = bits();
    store(all, ref_out, near_out);
    return static_cast<std::size_t>(std::popcount(all));
  }
  /// store() without entry distances.
  HWY_INLINE std::size_t store(std::uint32_t* HWY_RESTRICT ref_out) const {
    const std::uint32_t all = bits();
    ChildSlots::store(slots_of(all), node_.child, ref_out);
    return static_cast<std::size_t>(std::popcount(all));
  }
  /// store() with slots instead of references.
  HWY_INLINE std::size_t store_slots(std::uint32_t* HWY_RESTRICT slot_out,
                                     float* HWY_RESTRICT near_out) const {
    const std::uint32_t all = bits();
    const auto slots = slots_of(all);
    ChildSlots::store(slots, slot_out);
    ChildSlots::store_near(slots, boxes_, near_out);
    return static_cast<std::size_t>(std::popcount(all));
  }
  /// Writes the children at the positions whose bit is set.
  HWY_INLINE void store(std::uint32_t bits, std::uint32_t* HWY_RESTRICT ref_out,
                        float* HWY_RESTRICT near_out) const {
    const auto slots = slots_of(bits);
    ChildSlots::store(slots, node_.child, ref_out);
    ChildSlots::store_near(slots, boxes_, near_out);
  }

 private:
  HWY_INLINE ChildSlots::V slots_of(std::uint32_t bits) const {
    const auto slots = ChildSlots::set_bits(bits);
    return sorted_ ? ChildSlots::shuffle(order_, slots) : slots;
  }

  const WideNode& node_;
  const BoxCrossings& boxes_;
  ChildSlots::V met_, order_;
  bool sorted_ = false;  // known where `sort` is inlined
};

#elif !SIGHTLINE_NATIVE_COMPRESS

/// The children of a node, and which of them a ray meets. Construct it from the box tests, call
/// sort() if the order matters, then store(). Position i is child i of the WideNode, or after
/// sort() the i-th in the order far to near. The node must outlive it. Each instruction set has one
/// of these classes.
class ChildList {
 public:
  HWY_INLINE ChildList(const WideNode& node, const BoxCrossings& boxes) : node_(node) {
    for (std::size_t v = 0; v < kBoxVectors; ++v) {
      hn::Store(boxes.near[v], BoxLanes(), near_ + v * kBoxLanes);
      hn::Store(boxes.far[v], BoxLanes(), far_ + v * kBoxLanes);
    }
  }

  /// Sorts by the node's order for rays of an octant, from far to near.
  HWY_INLINE void sort(const WideNode& node, std::uint32_t octant) { order_ = node.order[octant]; }
  /// Bit i: the ray meets the box of the child at position i.
  HWY_INLINE std::uint32_t bits() const {
    std::uint32_t bits = 0;
    for (std::uint32_t i = 0; i < kArity; ++i) bits |= (met(slot(i)) ? 1u : 0u) << i;
    return bits;
  }

  /// Writes references and entry distances of the children that are met, in the order of positions.
  /// Returns their number. Eight elements of both arrays may be overwritten.
  HWY_INLINE std::size_t store(std::uint32_t* HWY_RESTRICT ref_out,
                               float* HWY_RESTRICT near_out) const {
    const std::size_t size = store_slots(ref_out, near_out);
    for (std::size_t i = 0; i < size; ++i) ref_out[i] = node_.child[ref_out[i]];
    return size;
  }
  /// store() without entry distances.
  HWY_INLINE std::size_t store(std::uint32_t* HWY_RESTRICT ref_out) const {
    std::size_t size = 0;
    for (std::uint32_t i = 0; i < kArity; ++i) {
      ref_out[size] = node_.child[slot(i)];
      size += met(slot(i)) ? 1u : 0u;
    }
    return size;
  }
  /// store() with slots instead of references.
  HWY_INLINE std::size_t store_slots(std::uint32_t* HWY_RESTRICT slot_out,
                                     float* HWY_RESTRICT near_out) const {
    std::size_t size = 0;
    for (std::uint32_t i = 0; i < kArity; ++i) {
      slot_out[size] = slot(i);
      near_out[size] = near_[slot(i)];
      size += met(slot(i)) ? 1u : 0u;
    }
    return size;
  }
  /// Writes the children at the positions whose bit is set.
  HWY_INLINE void store(std::uint32_t bits, std::uint32_t* HWY_RESTRICT ref_out,
                        float* HWY_RESTRICT near_out) const {
    for (; bits != 0; bits &= bits - 1) {
      const std::uint32_t child = slot(static_cast<std::uint32_t>(std::countr_zero(bits)));
      *ref_out++ = node_.child[child];
      *near_out++ = near_[child];
    }
  }

 private:
  HWY_INLINE std::uint32_t slot(std::uint32_t i) const { return order_ >> (3 * i) & 7u; }
  HWY_INLINE bool met(std::uint32_t slot) const { return near_[slot] <= far_[slot]; }

  const WideNode& node_;
  HWY_ALIGN float near_[kArity];
  HWY_ALIGN float far_[kArity];
  std::uint32_t order_ = 076543210u;
};

#endif

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
