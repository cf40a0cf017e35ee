#include "core/trace/decision.h"

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
