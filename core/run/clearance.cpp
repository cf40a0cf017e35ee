#include "core/run/clearance.h"

#include <algorithm>
#include <optional>
#include <string>

#include "core/run/engine_state.h"
#include "core/trace/search/clearance.h"

namespace sightline {

bool keep_the_same(const ResolvedFilter& a, const ResolvedFilter& b) {
  return std::equal(a.sides.begin(), a.sides.end(), b.sides.begin(), b.sides.end());
}

Status clearance(const Scene& scene, const ResolvedFilter& a, const ResolvedFilter& b,
                 const ClearanceQuestion& question, std::uint64_t most, const Deadline& deadline,
                 ClearanceAnswer& answer, QueryWork& work) {
  return within_memory([&]() -> Status {
    const TriangleGroup of_a(scene, a, deadline);
    std::optional<TriangleGroup> other;
    if (!keep_the_same(a, b)) other.emplace(scene, b, deadline);
    if (deadline.passed()) return out_of_time(deadline);
    Clearance search(scene, of_a, other ? *other : of_a, deadline);
    search.find(question, most);
    work.nodes += search.counts().nodes;
    work.exact_compares += search.counts().decisions.exact_compares;
    if (search.stopped()) return out_of_time(deadline);
    if (search.too_many()) {
      return Error{ErrorKind::kTooLarge, "TOO_MANY_HITS",
                   "more than " + std::to_string(most) +
                       " pairs are so near; choose less, or a smaller distance",
                   ""};
    }
    search.write(question.limit, answer);
    return success();
  });
}

}  // namespace sightline
