/// Clearance between two selections, on the thread that asks.

#include <optional>
#include <string>

#include "core/run/clash.h"
#include "core/run/engine_state.h"
#include "core/run/resolved_filter.h"
#include "core/trace/search/clearance.h"

namespace sightline {

Status Engine::clearance(const Scene& scene, const ResolvedFilter& a, const ResolvedFilter& b,
                         const ClearanceQuestion& question, const Deadline& deadline,
                         ClearanceAnswer& answer, QueryWork* work) const {
  return within_memory([&]() -> Status {
    const TriangleGroup of_a(scene, a, deadline);
    std::optional<TriangleGroup> other;
    if (!select_alike(a, b)) other.emplace(scene, b, deadline);
    if (deadline.passed()) return out_of_time(deadline);
    Clearance search(scene, of_a, other ? *other : of_a, deadline);
    search.find(question, question.total_max);
    if (work != nullptr) {
      work->nodes += search.counts().nodes;
      work->exact_compares += search.counts().decisions.exact_compares;
    }
    if (search.stopped()) return out_of_time(deadline);
    if (search.too_many()) {
      return Error{ErrorKind::kTooLarge, "TOO_MANY_HITS",
                   "more than " + std::to_string(question.total_max) +
                       " pairs are so near; choose less, or a smaller distance",
                   ""};
    }
    if (!question.kinds) {
      search.write(question.limit, answer);
      return success();
    }
    search.write(question.total_max, answer);
    return NodeClashes(*this, scene, {a, of_a}, {b, other ? *other : of_a}, question, deadline)
        .complete(answer);
  });
}

}  // namespace sightline
