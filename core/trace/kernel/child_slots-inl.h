// Vectors over the eight children of a node: results of box tests, slot numbers, and their
// permutation by table lookups. A slot is the index of a child in its WideNode, 0 to 7.

#if defined(SIGHTLINE_TRACE_CHILD_SLOTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_CHILD_SLOTS_INL_H_
#undef SIGHTLINE_TRACE_CHILD_SLOTS_INL_H_
#else
#define SIGHTLINE_TRACE_CHILD_SLOTS_INL_H_
#endif

#include "core/bvh/wide_tree.h"
#include "core/trace/kernel/compress_table.h"
#include "core/trace/kernel/simd-inl.h"

// Defines how this target compresses: by an instruction, by a table, or, if both are 0, one by one.
#undef SIGHTLINE_NATIVE_COMPRESS
#undef SIGHTLINE_TABLE_COMPRESS
#define SIGHTLINE_NATIVE_COMPRESS (HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3)
// EMU128 and SSE2 have no byte shuffle.
#if HWY_TARGET == HWY_EMU128 || HWY_TARGET == HWY_SCALAR || \
    (defined(HWY_SSE2) && HWY_TARGET == HWY_SSE2)
#define SIGHTLINE_TABLE_COMPRESS 0
#else
#define SIGHTLINE_TABLE_COMPRESS !SIGHTLINE_NATIVE_COMPRESS
#endif

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Lanes of the boxes of a node: float32 results of box tests, and references. A node takes
/// kBoxVectors vectors of kBoxLanes lanes.
using BoxLanes = hn::CappedTag<float, kArity>;
using RefLanes = hn::RebindToUnsigned<BoxLanes>;
constexpr std::size_t kBoxLanes = hn::MaxLanes(BoxLanes());
constexpr std::size_t kBoxVectors = kArity / kBoxLanes;

/// The entry and exit distances of a ray for the boxes of a node, in slots. The ray meets a box if
/// near <= far.
struct BoxCrossings {
  hn::Vec<BoxLanes> near[kBoxVectors], far[kBoxVectors];
};

/// Which child is visited first. kNearest: the nearest for the octant of the ray. kAny: the child
/// in the last slot, where builders put the child that most likely ends an any-hit query.
enum class Wanted { kNearest, kAny };

#if HWY_MAX_BYTES >= 32
/// The slots of the children from far to near, for rays of an octant.
HWY_INLINE hn::Vec<RefLanes> child_order(const WideNode& node, std::uint32_t octant) {
  // The permutation is eight fields of three bits. Each moves to the top of its lane, then down: a
  // mask of sevens would be a constant that g++ 12 makes anew at each use.
  HWY_ALIGN static constexpr std::uint32_t kUp[kArity] = {29, 26, 23, 20, 17, 14, 11, 8};
  const RefLanes du;
  return hn::ShiftRight<29>(hn::Shl(hn::Set(du, node.order[octant]), hn::Load(du, kUp)));
}
#endif

#if SIGHTLINE_TABLE_COMPRESS && HWY_MAX_BYTES >= 32

/// Operations on eight lanes of 32 bits: slot numbers or truth values.
class ChildSlots {
 public:
  using V = hn::Vec<RefLanes>;

  /// True in the lanes whose boxes are met.
  static HWY_INLINE V met(const BoxCrossings& boxes) {
    const BoxLanes df;
    return hn::BitCast(RefLanes(), hn::VecFromMask(df, hn::Le(boxes.near[0], boxes.far[0])));
  }
  /// The slots of the children from far to near, for rays of an octant.
  static HWY_INLINE V order(const WideNode& node, std::uint32_t octant) {
    return child_order(node, octant);
  }
  /// A bit for each lane that is true.
  static HWY_INLINE std::uint32_t bits(V truth) {
    const BoxLanes df;
    return mask_bits(df, hn::MaskFromVec(hn::BitCast(df, truth)));
  }
  /// Lane i of the result is lane index[i] of `from`.
  static HWY_INLINE V shuffle(V from, V index) {
    return hn::TableLookupLanes(from, hn::IndicesFromVec(RefLanes(), index));
  }
  /// The numbers of the set bits, in ascending order, then zeros.
  static HWY_INLINE V set_bits(std::uint32_t bits) {
    const hn::Rebind<std::uint8_t, RefLanes> d8;
    return hn::PromoteTo(RefLanes(), hn::Load(d8, kCompress[bits].data()));
  }
  /// Writes the slots.
  static HWY_INLINE void store(V slots, std::uint32_t* HWY_RESTRICT out) {
    hn::StoreU(slots, RefLanes(), out);
  }
  /// Writes the elements of `refs` at the slots.
  static HWY_INLINE void store(V slots, const std::uint32_t (&refs)[kArity],
                               std::uint32_t* HWY_RESTRICT out) {
    store(shuffle(hn::Load(RefLanes(), refs), slots), out);
  }
  /// Writes the entry distances of the slots.
  static HWY_INLINE void store_near(V slots, const BoxCrossings& boxes, float* HWY_RESTRICT out) {
    hn::StoreU(hn::TableLookupLanes(boxes.near[0], hn::IndicesFromVec(BoxLanes(), slots)),
               BoxLanes(), out);
  }
};

#elif SIGHTLINE_TABLE_COMPRESS

/// Operations on eight bytes: slot numbers or truth values.
class ChildSlots {
 public:
  using Bytes = hn::CappedTag<std::uint8_t, kArity>;
  using V = hn::Vec<Bytes>;

  /// True in the bytes whose boxes are met.
  static HWY_INLINE V met(const BoxCrossings& boxes) {
    const BoxLanes df;
    const hn::RebindToSigned<BoxLanes> di;
    const auto truth = [&](std::size_t i) {
      return hn::BitCast(di, hn::VecFromMask(df, hn::Le(boxes.near[i], boxes.far[i])));
    };
    // In order on 128 bits.
    const auto words = hn::ReorderDemote2To(hn::CappedTag<std::int16_t, 8>(), truth(0), truth(1));
    return hn::BitCast(Bytes(), hn::DemoteTo(hn::RebindToSigned<Bytes>(), words));
  }
  /// The slots of the children from far to near, for rays of an octant. node.order has eight fields
  /// of three bits. A multiplication moves each field to the top of a lane of 16 bits, and a shift
  /// moves it down.
  static HWY_INLINE V order(const WideNode& node, std::uint32_t octant) {
    using Words = hn::CappedTag<std::uint16_t, 8>;
    HWY_ALIGN static constexpr std::uint8_t kByte[16] = {0, 1, 0, 1, 0, 1, 1, 2,
                                                         1, 2, 1, 2, 2, 3, 2, 3};
    HWY_ALIGN static constexpr std::uint16_t kUp[8] = {1u << 13, 1u << 10, 1u << 7,  1u << 12,
                                                       1u << 9,  1u << 6,  1u << 11, 1u << 8};
    const hn::CappedTag<std::uint8_t, 16> d8;
    const Words dw;
    const auto packed = hn::BitCast(d8, hn::Set(RefLanes(), node.order[octant]));
    const auto words = hn::BitCast(dw, hn::TableLookupBytes(packed, hn::Load(d8, kByte)));
    const auto fields = hn::ShiftRight<13>(hn::Mul(words, hn::Load(dw, kUp)));
    return hn::DemoteTo(Bytes(), hn::BitCast(hn::RebindToSigned<Words>(), fields));
  }
  /// A bit for each byte that is true.
  static HWY_INLINE std::uint32_t bits(V truth) {
    return mask_bits(Bytes(), hn::MaskFromVec(truth));
  }
  /// Byte i of the result is byte index[i] of `from`.
  static HWY_INLINE V shuffle(V from, V index) { return hn::TableLookupBytes(from, index); }
  /// The numbers of the set bits, in ascending order, then zeros.
  static HWY_INLINE V set_bits(std::uint32_t bits) {
    return hn::Load(Bytes(), kCompress[bits].data());
  }
  /// Writes the slots, each as 32 bits.
  static HWY_INLINE void store(V slots, std::uint32_t* HWY_RESTRICT out) {
    const hn::CappedTag<std::uint8_t, 16> d16;
    const hn::CappedTag<std::uint8_t, 4> d4;
    const RefLanes du;
    const auto both = hn::Combine(d16, slots, slots);
    hn::StoreU(hn::PromoteTo(du, hn::LowerHalf(d4, slots)), du, out);
    hn::StoreU(
        hn::PromoteTo(du,
                      hn::LowerHalf(d4, hn::LowerHalf(Bytes(), hn::ShiftRightBytes<4>(d16, both)))),
        du, out + kBoxLanes);
  }
  /// Writes the elements of `refs` at the slots.
  static HWY_INLINE void store(V slots, const std::uint32_t (&refs)[kArity],
                               std::uint32_t* HWY_RESTRICT out) {
    const RefLanes du;
    const auto low = hn::Load(du, refs), high = hn::Load(du, refs + kBoxLanes);
    hn::StoreU(Moves(slots, 0).of(low, high), du, out);
    hn::StoreU(Moves(slots, 1).of(low, high), du, out + kBoxLanes);
  }
  /// Writes the entry distances of the slots.
  static HWY_INLINE void store_near(V slots, const BoxCrossings& boxes, float* HWY_RESTRICT out) {
    const RefLanes du;
    const BoxLanes df;
    const auto low = hn::BitCast(du, boxes.near[0]), high = hn::BitCast(du, boxes.near[1]);
    hn::StoreU(hn::BitCast(df, Moves(slots, 0).of(low, high)), df, out);
    hn::StoreU(hn::BitCast(df, Moves(slots, 1).of(low, high)), df, out + kBoxLanes);
  }

 private:
  /// Lookups of four lanes of 32 bits in a table of eight lanes, which is two vectors of four.
  struct Moves {
    using Sixteen = hn::CappedTag<std::uint8_t, 16>;
    hn::Vec<Sixteen> in_low, in_high;  ///< indices of bytes; an index of at least 128 gives 0

    HWY_INLINE Moves(V slots, std::size_t half) {
      HWY_ALIGN static constexpr std::uint8_t kSpread[2][16] = {
          {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3},
          {4, 4, 4, 4, 5, 5, 5, 5, 6, 6, 6, 6, 7, 7, 7, 7}};
      HWY_ALIGN static constexpr std::uint8_t kByte[16] = {0xf0, 0xf1, 0xf2, 0xf3, 0xf0, 0xf1,
                                                           0xf2, 0xf3, 0xf0, 0xf1, 0xf2, 0xf3,
                                                           0xf0, 0xf1, 0xf2, 0xf3};
      const Sixteen d;
      const hn::Repartition<std::uint16_t, Bytes> dw;
      // Slots below 8 times four bytes do not reach the next byte.
      const auto first = hn::BitCast(Bytes(), hn::ShiftLeft<2>(hn::BitCast(dw, slots)));
      const auto spread =
          hn::TableLookupBytes(hn::Combine(d, first, first), hn::Load(d, kSpread[half]));
      in_high = hn::Add(spread, hn::Load(d, kByte));  // bytes 16 to 31 become 0 to 15
      in_low = hn::Xor(in_high, hn::Set(d, 0xf0));    // bytes 0 to 15, the others 240 to 255
    }
    HWY_INLINE hn::Vec<RefLanes> of(hn::Vec<RefLanes> low, hn::Vec<RefLanes> high) const {
      const Sixteen d;
      return hn::BitCast(RefLanes(),
                         hn::Or(hn::TableLookupBytesOr0(hn::BitCast(d, low), in_low),
                                hn::TableLookupBytesOr0(hn::BitCast(d, high), in_high)));
    }
  };
};

#endif

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
