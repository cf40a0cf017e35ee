#include "core/trace/decision.h"

#include <algorithm>
#include <bit>

#include "core/trace/counting_sides.h"

namespace sightline {

namespace {

bool exact_hit_of(const Scene& scene, const Ray& ray, TriangleId id, ExactT& t) {
  return exact_hit(ray.origin, ray.direction, ray.tmin, ray.tmax, scene.world_triangle(id), t);
}

bool exact_hit_of(const RayQuestion& question, const Triangle& triangle, ExactHit& hit) {
  ++question.counts.exact_hits;
  const Ray ray = question.ray();
  return exact_hit(ray.origin, ray.direction, ray.tmin, ray.tmax, triangle,
                   shared_hit(ray.origin, ray.direction, triangle), hit);
}

/// The world triangle of a candidate, from its block, which the kernel has just read: the mesh is
/// far away.
Triangle triangle_of(const SceneView& scene, const Candidate& candidate) {
  const Affine& matrix = scene.description().instances[candidate.instance].world_from_mesh;
  const auto world = [&](std::size_t c) {
    return matrix.apply(candidate.block->corner(c, candidate.lane));
  };
  return {world(0), world(1), world(2)};
}

}  // namespace

namespace {

/// Whether both triangles lie in one plane across an axis: a ray that meets both meets them at one
/// t. Boxes that stand flush are the commonest tie there is, and this the cheapest way to see it.
bool in_one_axis_plane(const Triangle& a, const Triangle& b) {
  for (int k = 0; k < 3; ++k) {
    const double x = a.v0[k];
    if (a.v1[k] == x && a.v2[k] == x && b.v0[k] == x && b.v1[k] == x && b.v2[k] == x) return true;
  }
  return false;
}

}  // namespace

void ClosestHit::settle(const RayQuestion& question, const Candidate& other, Interval other_tau) {
  const TriangleId id = other.id();
  if (id == candidate.id()) return;
  // A ray inside that plane has no certain hits, so both t are the plane's.
  if (found() && in_one_axis_plane(triangle_of(question.scene, other),
                                   triangle_of(question.scene, candidate))) {
    if (id < candidate.id()) candidate = other;
    // Either interval contains the common t.
    tau = {std::max(tau.low, other_tau.low), std::min(tau.high, other_tau.high)};
    return;
  }
  examine(question, other);
}

/// compare() of t with the t of another triangle that the ray meets. Not inlined: it is rare, and
/// has large variables.
[[gnu::noinline]] static int compare_with(const RayQuestion& question, const ExactT& t,
                                          const Triangle& triangle) {
  ++question.counts.exact_compares;
  ExactHit other;
  exact_hit_of(question, triangle, other);
  return compare(t, other.t);
}

void ClosestHit::examine(const RayQuestion& question, Candidate other) {
  const TriangleId id = other.id();
  if (found() && id == candidate.id()) return;
  const Triangle triangle = triangle_of(question.scene, other);
  const auto nearest = [&] { return triangle_of(question.scene, candidate); };
  // One point of both, so one t, which is within the limits.
  const auto take_smaller_id = [&] {
    if (id < candidate.id()) candidate = other;
  };
  // The triangles around a vertex, after the first of them.
  const bool has_edge = found() && candidate.edge != 0;
  const CornerSet common = has_edge ? corners_at(triangle, nearest(), candidate.edge) : 0;
  if (common != 0 && certain_side_sign(question.ray().direction, triangle) != 0) {
    other.edge = common;
    return take_smaller_id();
  }
  ExactHit hit;
  if (!exact_hit_of(question, triangle, hit)) return;
  other.edge = hit.edge;
  // In the plane of one of them.
  if (common != 0 && common == other.edge) return take_smaller_id();
  const Interval own = question.tau_of(hit.t);
  if (found() && !(own.high < tau.low)) {
    if (own.low > tau.high) return;
    // The intervals overlap: exact t decides, then the smaller id.
    const int order = compare_with(question, hit.t, nearest());
    if (order > 0 || (order == 0 && candidate.id() < id)) return;
  }
  tau = own;
  candidate = other;
}

std::uint32_t counting_lanes(const RayQuestion& question, const ResolvedFilter& resolved,
                             const LeafBlock& block, std::uint32_t instance, std::uint32_t lanes,
                             std::uint32_t certain, std::uint32_t back) {
  if (!resolved.masks.empty() &&
      (resolved.masks[instance] & question.rays.mask[question.number]) == 0) {
    return 0;
  }
  for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<std::uint32_t>(std::countr_zero(rest));
    const Candidate candidate{&block, lane, instance};
    const std::uint8_t sides = counting_sides(question.scene.scene(), resolved, candidate.id());
    if (sides == ResolvedFilter::kAll) continue;
    std::uint8_t met = 0;
    if ((certain >> lane & 1u) != 0) {
      met = (back >> lane & 1u) != 0 ? ResolvedFilter::kBack : ResolvedFilter::kFront;
    } else if (sides != 0) {
      const Triangle triangle = triangle_of(question.scene, candidate);
      if (is_finite(triangle)) {
        const int sign = side_sign(question.ray().direction, triangle);
        met = sign < 0   ? ResolvedFilter::kFront
              : sign > 0 ? ResolvedFilter::kBack
                         : ResolvedFilter::kEdgeOn;
      }
    }
    if ((sides & met) == 0) lanes &= ~(1u << lane);
  }
  return lanes;
}

bool exact_hit_of(const RayQuestion& question, TriangleId id, ExactT& t) {
  ++question.counts.exact_hits;
  return exact_hit_of(question.scene.scene(), question.ray(), id, t);
}

bool examine_any(const RayQuestion& question, TriangleId id) {
  ExactT t;
  return exact_hit_of(question, id, t);
}

double exact_t(const Scene& scene, const Ray& ray, TriangleId id) {
  return exact_t(ray, scene.world_triangle(id));
}

double exact_t(const Ray& ray, const Triangle& triangle) {
  ExactHit hit;
  exact_hit(ray.origin, ray.direction, ray.tmin, ray.tmax, triangle,
            shared_hit(ray.origin, ray.direction, triangle), hit);
  return hit.t.rounded();
}

HitDetail hit_detail(const Scene& scene, const Ray& ray, TriangleId id) {
  ExactT t;
  if (!exact_hit_of(scene, ray, id, t)) return {};
  const ExactDetail detail = exact_detail(ray.origin, ray.direction, scene.world_triangle(id), t);
  return {detail.position, detail.normal, detail.u, detail.v, detail.front};
}

bool hit_on_edge(const Scene& scene, const Ray& ray, TriangleId id, const HitDetail& detail) {
  // Weights are within 2^-50, so these are three that are certainly positive.
  constexpr double kApart = 0x1p-48;
  if (detail.u > kApart && detail.v > kApart && detail.u + detail.v < 1 - kApart) return false;
  ExactT t;
  return exact_hit_of(scene, ray, id, t) &&
         is_on_edge(ray.origin, ray.direction, scene.world_triangle(id), t);
}

}  // namespace sightline
