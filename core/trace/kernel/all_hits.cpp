#include "core/trace/kernel/all_hits.h"

#include <algorithm>
#include <limits>

#include "core/trace/kernel/kernel.h"

namespace sightline {
namespace {

/// An exact t takes 0.2 to some 20 microseconds, reading the clock 0.03.
constexpr std::uint32_t kExactBetweenLooks = 64;
/// So many are sorted in some milliseconds.
constexpr std::ptrdiff_t kSortedAtOnce = 1 << 15;

void append(double t, TriangleId id, HitBatch& hits) {
  hits.t.push_back(t);
  hits.instance.push_back(id.instance);
  hits.triangle.push_back(id.triangle);
}

constexpr auto by_id = [](const auto& a, const auto& b) { return a.id < b.id; };
constexpr auto by_low = [](const auto& a, const auto& b) { return a.tau.low < b.tau.low; };
constexpr auto by_high = [](const auto& a, const auto& b) { return a.tau.high < b.tau.high; };

}  // namespace

bool AllHits::meets(TriangleId id, ExactT& t) {
  if (++exact_ % kExactBetweenLooks == 0) counts_.is_too_late();
  return !counts_.stopped && exact_hit_of(question_, id, t);
}

void AllHits::make_room() {
  if (entries_.size() >= room_) return drop_all_but_first();
  // Not beyond `room_`, as the vector would; and never a little short of it, or the old and the new
  // storage would have nearly twice that.
  const std::size_t size = entries_.size();
  entries_.reserve(size >= room_ / 4 ? room_ : std::max<std::size_t>(16, 2 * size));
}

void AllHits::examine(TriangleId id) {
  ExactT t;
  if (!meets(id, t)) return;
  if (crossings_ == Crossings::kOnce &&
      !exact_crossing(question_.ray().origin, question_.ray().direction,
                      question_.scene.world_triangle(id))) {
    return;
  }
  ++total_;
  if (limit_ == 0) return;
  Interval tau = question_.tau_of(t);
  // What is not a number, as far from an origin that is unknown, has no order: it may be anything.
  if (!(tau.low <= tau.high)) tau = {-ClosestHit::kNever, ClosestHit::kNever};
  keep({id, tau});
}

void AllHits::drop_all_but_first() {
  if (entries_.size() <= limit_) return;
  // `limit_` entries are not beyond the least `limit_` upper ends, so what is certainly beyond is
  // out; and fewer are before the least `limit_` lower ends, so what certainly is, is in.
  const Place begin = entries_.begin(), end = entries_.end();
  const Place last = begin + static_cast<std::ptrdiff_t>(limit_ - 1);
  std::nth_element(begin, last, end, by_low);
  const double low = last->tau.low;
  std::nth_element(begin, last, end, by_high);
  const double high = last->tau.high;
  const Place open = std::partition(begin, end, [&](const Entry& e) { return e.tau.high < low; });
  const Place out = std::partition(open, end, [&](const Entry& e) { return e.tau.low <= high; });
  select(open, out, limit_ - static_cast<std::size_t>(open - begin));
  entries_.resize(limit_);
  farthest_ = high;
  counts_.is_too_late();
}

AllHits::Same AllHits::split(Place begin, Place end, bool rounds) {
  // From the middle: what intervals have put in order already is halved.
  std::swap(*begin, *(begin + (end - begin) / 2));
  const Interval tau = begin->tau;
  ExactT pivot, t;
  meets(begin->id, pivot);
  Same same{begin, begin + 1};
  for (Place above = end; same.end != above && !counts_.stopped;) {
    Entry& entry = *same.end;
    int order = entry.tau.high < tau.low ? -1 : entry.tau.low > tau.high ? 1 : 0;
    if (order == 0 && meets(entry.id, t)) {
      ++question_.counts.exact_compares;
      order = compare(t, pivot);
    }
    if (order < 0) {
      std::swap(*same.begin++, *same.end++);
    } else if (order > 0) {
      std::swap(entry, *--above);
    } else {
      ++same.end;
    }
  }
  if (rounds && !counts_.stopped) same.t = pivot.rounded();
  return same;
}

void AllHits::select(Place begin, Place end, std::size_t wanted) {
  while (wanted != 0 && wanted < static_cast<std::size_t>(end - begin)) {
    const Same same = split(begin, end, false);
    if (counts_.stopped) return;
    const auto before = static_cast<std::size_t>(same.begin - begin);
    const auto not_behind = static_cast<std::size_t>(same.end - begin);
    if (wanted <= before) {
      end = same.begin;
    } else if (wanted <= not_behind) {
      std::nth_element(same.begin, begin + static_cast<std::ptrdiff_t>(wanted), same.end, by_id);
      return;
    } else {
      begin = same.end;
      wanted -= not_behind;
    }
  }
}

template <class Less>
bool AllHits::sort(Place begin, Place end, Less less) {
  while (end - begin > kSortedAtOnce) {
    if (counts_.is_too_late()) return false;
    const Place middle = begin + (end - begin) / 2;
    std::nth_element(begin, middle, end, less);
    if (!sort(begin, middle, less)) return false;
    begin = middle;
  }
  std::sort(begin, end, less);
  return true;
}

void AllHits::append_exactly(Place begin, Place end, HitBatch& hits) {
  // Of pieces behind one another the first is on top: those at one t, or not yet in order.
  struct Piece {
    Same range;
    bool same;
  };
  std::vector<Piece> pieces{{{begin, end}, false}};
  while (!pieces.empty() && !counts_.stopped) {
    const Piece piece = pieces.back();
    pieces.pop_back();
    const Same& range = piece.range;
    if (piece.same) {
      if (!sort(range.begin, range.end, by_id)) return;
      for (Place entry = range.begin; entry != range.end; ++entry) append(range.t, entry->id, hits);
      continue;
    }
    const Same same = split(range.begin, range.end, true);
    if (same.end != range.end) pieces.push_back({{same.end, range.end}, false});
    pieces.push_back({same, true});
    if (same.begin != range.begin) pieces.push_back({{range.begin, same.begin}, false});
  }
}

void AllHits::append_sorted(HitBatch& hits) {
  drop_all_but_first();
  if (counts_.stopped || !sort(entries_.begin(), entries_.end(), by_low)) return;
  // Intervals order what they separate, exact t the rest: this is the order of (t, id).
  for (Place begin = entries_.begin(); begin != entries_.end() && !counts_.stopped;) {
    Place end = begin + 1;
    double high = begin->tau.high;
    while (end != entries_.end() && end->tau.low <= high) high = std::max(high, end++->tau.high);
    if (ExactT t; end - begin > 1) {
      append_exactly(begin, end, hits);
    } else if (meets(begin->id, t)) {
      append(t.rounded(), begin->id, hits);
    }
    begin = end;
  }
}

}  // namespace sightline
