#include "core/trace/decision.h"

#include <algorithm>

namespace sightline {

namespace {
bool exact_hit_of(const Scene& scene, const Ray& ray, TriangleId id, ExactT& t) {
  return exact_hit(ray.origin, ray.direction, ray.tmin, ray.tmax, scene.world_triangle(id), t);
}
}  // namespace

void ClosestDecision::accept(TriangleId id, Interval tau) { challenge(id, tau, nullptr); }

void ClosestDecision::examine(TriangleId id) {
  if (id == id_) return;
  ++counts_.exact_hits;
  ExactT t;
  if (!exact_hit_of(scene_, ray_, id, t)) return;
  challenge(id, anchored_.tau_of(t.rounded()), &t);
}

void ClosestDecision::challenge(TriangleId id, Interval tau, const ExactT* exact) {
  if (found()) {
    if (id == id_ || tau.low > tau_.high) return;
    if (!(tau.high < tau_.low)) {
      // The intervals overlap: exact t decides, then the smaller id.
      ++counts_.exact_compares;
      ExactT own;
      if (exact == nullptr) {
        if (!exact_hit_of(scene_, ray_, id, own)) return;  // accepted lanes are hits: not reached
        exact = &own;
      }
      const int order = compare(*exact, this->exact());
      if (order > 0 || (order == 0 && id_ < id)) return;
      id_ = id;
      tau_ = tau;
      bound_ = tau.high;
      exact_ = *exact;
      exact_known_ = true;
      return;
    }
  }
  id_ = id;
  tau_ = tau;
  bound_ = tau.high;
  exact_known_ = exact != nullptr;
  if (exact_known_) exact_ = *exact;
}

const ExactT& ClosestDecision::exact() {
  if (!exact_known_) {
    exact_hit_of(scene_, ray_, id_, exact_);
    exact_known_ = true;
  }
  return exact_;
}

void AllDecision::examine(TriangleId id) {
  ++counts_.exact_hits;
  auto t = std::make_unique<ExactT>();
  if (!exact_hit_of(scene_, ray_, id, *t)) return;
  if (crossings_ == Crossings::kOnce &&
      !exact_crossing(ray_.origin, ray_.direction, scene_.world_triangle(id))) {
    return;
  }
  entries_.push_back({id, anchored_.tau_of(t->rounded()), std::move(t)});
}

const ExactT& AllDecision::exact_of(Entry& entry) {
  if (entry.exact == nullptr) {
    entry.exact = std::make_unique<ExactT>();
    exact_hit_of(scene_, ray_, entry.id, *entry.exact);
  }
  return *entry.exact;
}

void AllDecision::append_sorted(std::size_t limit, HitBatch& hits) {
  // Intervals order what they separate, exact t the rest: together the order of (t, id).
  std::vector<Entry*> order;
  order.reserve(entries_.size());
  for (Entry& entry : entries_) order.push_back(&entry);
  std::sort(order.begin(), order.end(), [&](Entry* a, Entry* b) {
    if (a->tau.high < b->tau.low) return true;
    if (b->tau.high < a->tau.low || a == b) return false;
    ++counts_.exact_compares;
    const int sign = compare(exact_of(*a), exact_of(*b));
    return sign != 0 ? sign < 0 : a->id < b->id;
  });
  if (order.size() > limit) order.resize(limit);
  for (Entry* entry : order) {
    hits.t.push_back(exact_of(*entry).rounded());
    hits.instance.push_back(entry->id.instance);
    hits.triangle.push_back(entry->id.triangle);
  }
}

bool examine_any(const Scene& scene, const Ray& ray, TriangleId id, DecisionCounts& counts) {
  ++counts.exact_hits;
  ExactT t;
  return exact_hit_of(scene, ray, id, t);
}

HitDetail hit_detail(const Scene& scene, const Ray& ray, TriangleId id) {
  ExactT t;
  if (!exact_hit_of(scene, ray, id, t)) return {};
  const ExactDetail detail = exact_detail(ray.origin, ray.direction, scene.world_triangle(id), t);
  return {detail.position, detail.normal, detail.u, detail.v, detail.front};
}

}  // namespace sightline
