#include "tests/oracle/detail_check.h"

#include <algorithm>
#include <cmath>

#include "core/base/infinity.h"

namespace sightline::oracle {
namespace {

mpq_class power_of_two(long exponent) { return to_mpq(Rational{1, 1, exponent}); }

}  // namespace

DetailErrors check_detail(const Ray& ray, const Triangle& triangle, const Rational& t,
                          const HitDetail& detail) {
  const ExactDetail truth = exact_detail(ray, triangle, t);
  DetailErrors errors;

  for (int k = 0; k < 3; ++k) {
    const mpq_class& exact_value = truth.position[static_cast<std::size_t>(k)];
    if (!std::isfinite(detail.position[k])) {
      errors.position_ulp = kInf;
      errors.position_kept = false;
      continue;
    }
    const mpq_class error = abs(mpq_class(detail.position[k]) - exact_value);
    const mpq_class in_ulp = error / power_of_two(ulp_exponent(exact_value));
    if (in_ulp > 1) errors.position_kept = false;
    errors.position_ulp = std::max(errors.position_ulp, in_ulp.get_d());
  }

  const std::pair<double, const mpq_class&> weights[] = {{detail.u, truth.u}, {detail.v, truth.v}};
  for (const auto& [value, exact_value] : weights) {
    if (!std::isfinite(value)) {
      errors.barycentric = kInf;
      errors.barycentric_kept = false;
      continue;
    }
    const mpq_class error = abs(mpq_class(value) - exact_value);
    if (error > power_of_two(-50)) errors.barycentric_kept = false;
    errors.barycentric = std::max(errors.barycentric, error.get_d());
  }

  // The exact unit normal to 256 bits: far below 1e-15, so the comparison is not in doubt. The
  // exponent of mpf_class has no bound that float64 triangles could reach.
  constexpr mp_bitcnt_t kBits = 256;
  const auto& n = truth.normal;
  const mpf_class square(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], kBits);
  const mpf_class length = sqrt(square);
  mpf_class distance(0, kBits);
  bool finite = true;
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(detail.normal[k])) {
      finite = false;
      break;
    }
    const mpf_class component(n[static_cast<std::size_t>(k)], kBits);
    const mpf_class error = component / length - mpf_class(detail.normal[k], kBits);
    distance += error * error;
  }
  distance = sqrt(distance);
  errors.normal = finite ? distance.get_d() : kInf;
  errors.normal_kept = finite && distance <= mpf_class(1e-15, kBits);

  errors.front_wrong = detail.front != truth.front;
  return errors;
}

}  // namespace sightline::oracle
