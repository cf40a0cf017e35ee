// OneByOne: broadcasts single triangles of a block to all lanes, for filters of many rays and one
// triangle.

#if defined(SIGHTLINE_TRACE_ONE_BY_ONE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_ONE_BY_ONE_INL_H_
#undef SIGHTLINE_TRACE_ONE_BY_ONE_INL_H_
#else
#define SIGHTLINE_TRACE_ONE_BY_ONE_INL_H_
#endif

#include "core/trace/kernel/filter-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Triangles of a block, as LaneCorners or LaneEdges (filter-inl.h), stored so that each can be
/// loaded into all lanes.
template <template <class> class Triangles>
class OneByOne {
 public:
  HWY_INLINE explicit OneByOne(const Triangles<FilterLanes>& triangles) { store(triangles); }

  /// Triangle `lane` (0 to 3) in every lane of D.
  template <class D>
  HWY_INLINE Triangles<D> in_every_lane(D d, std::size_t lane) const {
    Triangles<D> one;
    load(d, lane, one);
    return one;
  }

 private:
  using Three = hn::Vec<FilterLanes>[3];

  HWY_INLINE void store(const LaneCorners<FilterLanes>& from) {
    store(from.x, 0);
    store(from.y, 3);
    store(from.z, 6);
  }
  HWY_INLINE void store(const LaneEdges<FilterLanes>& from) {
    store(from.normal_x, 0);
    store(from.normal_y, 3);
    store(from.normal_z, 6);
    store(from.z, 9);
    error_ = from.error;
  }
  HWY_INLINE void store(const Three& from, std::size_t at) {
    SIGHTLINE_UNROLL
    for (std::size_t c = 0; c < 3; ++c) hn::Store(from[c], FilterLanes(), columns_[at + c]);
  }
  template <class D>
  HWY_INLINE void load(D d, std::size_t lane, LaneCorners<D>& to) const {
    load(d, lane, 0, to.x);
    load(d, lane, 3, to.y);
    load(d, lane, 6, to.z);
  }
  template <class D>
  HWY_INLINE void load(D d, std::size_t lane, LaneEdges<D>& to) const {
    load(d, lane, 0, to.normal_x);
    load(d, lane, 3, to.normal_y);
    load(d, lane, 6, to.normal_z);
    load(d, lane, 9, to.z);
    to.error = error_;
  }
  template <class D>
  HWY_INLINE void load(D d, std::size_t lane, std::size_t at, hn::Vec<D> (&to)[3]) const {
    SIGHTLINE_UNROLL
    for (std::size_t c = 0; c < 3; ++c) to[c] = hn::Set(d, columns_[at + c][lane]);
  }

  HWY_ALIGN double columns_[12][kLanes];
  double error_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
