// Traversal with a resolved filter. A triangle that does not count is removed before it is compared
// with any other, so it hides nothing behind it.

#if defined(SIGHTLINE_TRACE_FILTERED_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_FILTERED_INL_H_
#undef SIGHTLINE_TRACE_FILTERED_INL_H_
#else
#define SIGHTLINE_TRACE_FILTERED_INL_H_
#endif

#include "core/query/hit_filter.h"
#include "core/trace/kernel/single-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// A sink (single-inl.h) that passes only the triangles that count to another sink. Refers to
/// `resolved`, which must outlive it.
template <class Sink>
struct Filtered {
  static constexpr Wanted kWanted = Sink::kWanted;
  const ResolvedFilter& resolved;
  Sink sink;

  double bound() const { return sink.bound(); }
  bool take(const LeafBlock& block, std::uint32_t instance, const LeafVerdict& verdict) {
    LeafVerdict left = verdict;
    const std::uint32_t lanes =
        counting_lanes(sink.question, resolved, block, instance, verdict.accept | verdict.examine,
                       verdict.accept, verdict.back);
    left.accept &= lanes;
    left.examine &= lanes;
    return (left.accept | left.examine) != 0 && sink.take(block, instance, left);
  }
};

/// Traces rays [begin, end) one by one, for the triangles that count. Makes a sink for each ray by
/// make_sink(question, tau_max), and calls done(i, sink) after ray i was traced.
template <class MakeSink, class Done>
void trace_filtered(const SceneView& scene, const RayBatch& rays, std::size_t begin,
                    std::size_t end, const ResolvedFilter& resolved, TraceCounts& counts,
                    MakeSink make_sink, Done done) {
  Stack stack;
  Traversal traversal(scene, rays, stack, counts);
  for (std::size_t i = begin; i < end; ++i) {
    traversal.prepare(i);
    const RayQuestion question{scene, rays, i, counts.decisions};
    auto sink = make_sink(question, traversal.tau_max());
    Filtered<decltype(sink)> filtered{resolved, std::move(sink)};
    traversal.run(filtered);
    done(i, filtered.sink);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
