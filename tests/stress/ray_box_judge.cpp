#include <algorithm>
#include <sstream>

#include "core/base/infinity.h"
#include "core/geometry/ray_box.h"
#include "tests/stress/ray_box_cases.h"
#include "tests/stress/ray_box_truth.h"
#include "tests/support/float_text.h"

namespace sightline::stress {

namespace {

using test::same_bits;

/// What the product must say of an exact t: rounded once, zero positive, nothing as an infinity.
double rounded(const std::optional<mpq_class>& t, double nothing) {
  if (!t) return nothing;
  return oracle::round_to_double(oracle::Rational{t->get_num(), t->get_den(), 0}) + 0.0;
}

std::string check_outcome(const RayBoxAnswer& answer, const RayBoxTruth& truth) {
  switch (answer.outcome) {
    case RayBoxOutcome::kHit:
      return truth.hit ? "" : "false hit";
    case RayBoxOutcome::kApart:
      if (truth.line.hit) return "false miss (apart)";
      if (answer.apart[0] >= answer.apart[1]) return "slabs are not two in order";
      return truth.exclude(answer.apart[0], answer.apart[1]) ? ""
                                                             : "slabs do not exclude each other";
    case RayBoxOutcome::kBeside:
      if (truth.line.hit) return "false miss (beside)";
      if (answer.apart[0] != answer.apart[1]) return "beside names two slabs";
      return truth.exclude(answer.apart[0], answer.apart[0]) ? "" : "slab does not exclude alone";
    case RayBoxOutcome::kBehind:
      return truth.behind ? "" : "not behind";
    case RayBoxOutcome::kBeyond:
      return truth.beyond && !truth.behind ? "" : "not beyond";
  }
  return "no outcome";
}

std::string check_faces(const RayBoxAnswer& answer, const RayBoxTruth& truth) {
  std::array<bool, 6> listed{};
  for (std::size_t i = 0; i < answer.faces.count; ++i) {
    const BoxFace face = answer.faces.face[i];
    bool& slot = listed[2u * face.axis + (face.upper ? 1u : 0u)];
    if (slot) return "a face is listed twice";
    slot = true;
  }
  return listed == truth.faces ? "" : "wrong faces";
}

std::string check(const RayBoxAnswer& answer, const PlaneTs& planes, const RayBoxTruth& truth) {
  if (std::string fault = check_outcome(answer, truth); !fault.empty()) return fault;
  if (answer.inside != truth.line.origin_inside) return "wrong inside";
  if (answer.on_surface != truth.line.origin_on_surface) return "wrong on_surface";
  for (std::size_t i = 0; i < 6; ++i) {
    if (planes[i].has_value() != truth.planes[i].has_value()) return "a plane's t should (not) be";
    if (planes[i] && !same_bits(*planes[i], rounded(truth.planes[i], 0)))
      return "wrong t of a plane";
  }
  if (!truth.line.hit) return "";
  if (!same_bits(answer.t_enter, rounded(truth.line.enter, -kInf))) return "wrong t_enter";
  if (!same_bits(answer.t_exit, rounded(truth.line.leave, kInf))) return "wrong t_exit";
  if (!truth.hit) return "";
  if (!same_bits(answer.t, rounded(truth.t, kInf))) return "wrong t";
  return check_faces(answer, truth);
}

oracle::ExactBox exact(const Box3d& box) { return oracle::axis_aligned(box); }
oracle::ExactBox exact(const OrientedBox& box) {
  return oracle::oriented_by_slabs(box.center, box.axes, box.half);
}

template <class Box>
RayBoxVerdict judge_box(const Ray& ray, const Box& box) {
  const RayBoxTruth truth = ray_box_truth(ray, exact(box));
  const RayBoxAnswer answer = ray_box(ray.origin, ray.direction, ray.tmin, ray.tmax, box);
  const PlaneTs planes = ray_box_planes(ray.origin, ray.direction, box);

  RayBoxVerdict verdict;
  verdict.fault = check(answer, planes, truth);
  verdict.hit = truth.hit;
  const auto is_limit = [&](const std::optional<mpq_class>& t) {
    return t && (cmp(*t, std::isfinite(ray.tmin) ? ray.tmin : 0) == 0 ||
                 (std::isfinite(ray.tmax) && cmp(*t, ray.tmax) == 0));
  };
  verdict.touching =
      truth.line.hit &&
      (truth.line.origin_on_surface ||
       std::count(truth.faces.begin(), truth.faces.end(), true) > 1 ||
       (truth.line.enter && truth.line.leave && *truth.line.enter == *truth.line.leave) ||
       is_limit(truth.line.enter) || is_limit(truth.line.leave));
  return verdict;
}

}  // namespace

RayBoxVerdict judge(const RayBoxCase& test) {
  return test.oriented ? judge_box(test.ray, *test.oriented) : judge_box(test.ray, test.aligned);
}

std::string describe(const RayBoxCase& test) {
  std::ostringstream out;
  out << std::hexfloat;
  const auto put = [&](const char* name, const Vec3d& v) {
    out << name << " {" << v.x << ", " << v.y << ", " << v.z << "} ";
  };
  put("origin", test.ray.origin);
  put("direction", test.ray.direction);
  out << "limits " << test.ray.tmin << " " << test.ray.tmax << " ";
  if (test.oriented) {
    put("center", test.oriented->center);
    put("half", test.oriented->half);
    for (const Vec3d& axis : test.oriented->axes) put("axis", axis);
  } else {
    put("min", test.aligned.min);
    put("max", test.aligned.max);
  }
  return out.str();
}

}  // namespace sightline::stress
