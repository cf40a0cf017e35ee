#include "tests/contestants/slab_tests.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/infinity.h"

namespace sightline::contestants {

namespace {

struct Span {
  double enter = -kInf;
  double exit = kInf;
};

/// The general loop of the lectures: start at -inf and +inf, divide, swap, keep the larger entry
/// and the smaller exit. `outside` decides what becomes of a parallel ray.
template <class Outside>
bool swap_loop(const Ray& ray, const Box3d& box, Outside outside, Span& span) {
  for (int k = 0; k < 3; ++k) {
    const double o = ray.origin[k];
    const double d = ray.direction[k];
    if (d == 0) {
      if (outside(o, box.min[k], box.max[k])) return false;
      continue;
    }
    double t1 = (box.min[k] - o) / d;
    double t2 = (box.max[k] - o) / d;
    if (t1 > t2) std::swap(t1, t2);
    if (t1 > span.enter) span.enter = t1;
    if (t2 < span.exit) span.exit = t2;
    if (span.enter > span.exit) return false;
  }
  return true;
}

bool is_outside(double o, double min, double max) { return o < min || o > max; }

bool in_limits(const Span& span, const Ray& ray) {
  return span.exit >= ray.tmin && span.enter <= ray.tmax;
}

SlabAnswer slab_swap_divide(const Ray& ray, const Box3d& box) {
  Span span;
  const bool hit = swap_loop(ray, box, is_outside, span) && in_limits(span, ray);
  return {hit, span.enter >= ray.tmin ? span.enter : span.exit, span.enter, span.exit};
}

/// [Williams2005] as printed: strict limits, multiplication by an inverse.
SlabAnswer williams2005(const Ray& ray, const Box3d& box) {
  const std::array<Vec3d, 2> parameters{box.min, box.max};
  const Vec3d inverse{1 / ray.direction.x, 1 / ray.direction.y, 1 / ray.direction.z};
  const std::array<std::size_t, 3> sign{inverse.x < 0 ? 1u : 0u, inverse.y < 0 ? 1u : 0u,
                                        inverse.z < 0 ? 1u : 0u};
  const auto plane = [&](std::size_t side, int k) {
    return (parameters[side][k] - ray.origin[k]) * inverse[k];
  };
  double tmin = plane(sign[0], 0);
  double tmax = plane(1 - sign[0], 0);
  const double tymin = plane(sign[1], 1);
  const double tymax = plane(1 - sign[1], 1);
  if ((tmin > tymax) || (tymin > tmax)) return {};
  if (tymin > tmin) tmin = tymin;
  if (tymax < tmax) tmax = tymax;
  const double tzmin = plane(sign[2], 2);
  const double tzmax = plane(1 - sign[2], 2);
  if ((tmin > tzmax) || (tzmin > tmax)) return {};
  if (tzmin > tmin) tmin = tzmin;
  if (tzmax < tmax) tmax = tzmax;
  return {(tmin < ray.tmax) && (tmax > ray.tmin), tmin >= ray.tmin ? tmin : tmax, tmin, tmax};
}

SlabAnswer min_max_answer(const Span& span, const Ray& ray) {
  return {span.exit >= std::max(span.enter, ray.tmin) && span.enter <= ray.tmax,
          span.enter >= ray.tmin ? span.enter : span.exit, span.enter, span.exit};
}

SlabAnswer branchless_min_max(const Ray& ray, const Box3d& box) {
  Span span;
  for (int k = 0; k < 3; ++k) {
    const double inverse = 1 / ray.direction[k];
    const double t1 = (box.min[k] - ray.origin[k]) * inverse;
    const double t2 = (box.max[k] - ray.origin[k]) * inverse;
    span.enter = std::max(span.enter, std::min(t1, t2));
    span.exit = std::min(span.exit, std::max(t1, t2));
  }
  return min_max_answer(span, ray);
}

/// The same with one fused operation per plane and a product of origin and inverse kept per ray.
SlabAnswer fma_inverse(const Ray& ray, const Box3d& box) {
  Span span;
  for (int k = 0; k < 3; ++k) {
    const double inverse = 1 / ray.direction[k];
    const double shift = -ray.origin[k] * inverse;
    const double t1 = std::fma(box.min[k], inverse, shift);
    const double t2 = std::fma(box.max[k], inverse, shift);
    span.enter = std::max(span.enter, std::min(t1, t2));
    span.exit = std::min(span.exit, std::max(t1, t2));
  }
  return min_max_answer(span, ray);
}

/// [Ize2013]: comparisons that drop NaN, and an exit that is moved back by 2 gamma(3).
SlabAnswer ize2013_padded(const Ray& ray, const Box3d& box) {
  const auto larger = [](double a, double b) { return a > b ? a : b; };
  const auto smaller = [](double a, double b) { return a < b ? a : b; };
  Span span{ray.tmin, ray.tmax};
  for (int k = 0; k < 3; ++k) {
    const double inverse = 1 / ray.direction[k];
    const bool negative = inverse < 0;
    const double near = ((negative ? box.max[k] : box.min[k]) - ray.origin[k]) * inverse;
    const double far = ((negative ? box.min[k] : box.max[k]) - ray.origin[k]) * inverse;
    span.enter = larger(near, span.enter);
    span.exit = smaller(far, span.exit);
  }
  constexpr double kGamma3 = 3 * 0x1p-53 / (1 - 3 * 0x1p-53);
  return {span.enter <= span.exit * (1 + 2 * kGamma3), span.enter, span.enter, span.exit};
}

/// One text rejects a parallel ray when its origin is between the planes.
SlabAnswer inverted_parallel(const Ray& ray, const Box3d& box) {
  Span span;
  const auto inverted = [](double o, double min, double max) { return !is_outside(o, min, max); };
  const bool hit = swap_loop(ray, box, inverted, span) && in_limits(span, ray);
  return {hit, span.enter >= ray.tmin ? span.enter : span.exit, span.enter, span.exit};
}

/// The slides' second iteration orders the planes but divides by |d|: the sign is lost.
SlabAnswer slide_iteration_2(const Ray& ray, const Box3d& box) {
  Span span;
  for (int k = 0; k < 3; ++k) {
    const double o = ray.origin[k];
    const double d = ray.direction[k];
    if (d == 0) {
      if (is_outside(o, box.min[k], box.max[k])) return {};
      continue;
    }
    span.enter = std::max(span.enter, (box.min[k] - o) / std::abs(d));
    span.exit = std::min(span.exit, (box.max[k] - o) / std::abs(d));
  }
  return {span.enter <= span.exit && span.exit >= 0, span.enter, span.enter, span.exit};
}

/// The form that Williams et al. set out to mend: d >= 0 takes the wrong branch for -0.
SlabAnswer d_ge_0(const Ray& ray, const Box3d& box) {
  const auto plane = [&](int k, bool near) {
    const bool lower = (ray.direction[k] >= 0) == near;
    return ((lower ? box.min[k] : box.max[k]) - ray.origin[k]) / ray.direction[k];
  };
  double tmin = plane(0, true);
  double tmax = plane(0, false);
  for (int k = 1; k < 3; ++k) {
    const double near = plane(k, true);
    const double far = plane(k, false);
    if ((tmin > far) || (near > tmax)) return {};
    if (near > tmin) tmin = near;
    if (far < tmax) tmax = far;
  }
  return {(tmin <= ray.tmax) && (tmax >= ray.tmin), tmin >= ray.tmin ? tmin : tmax, tmin, tmax};
}

/// "If the entry is positive it is the answer, else the exit": an origin on the entry face is told
/// about the far one.
SlabAnswer tgmin_positive(const Ray& ray, const Box3d& box) {
  SlabAnswer answer = slab_swap_divide(ray, box);
  answer.t = answer.enter > 0 ? answer.enter : answer.exit;
  return answer;
}

/// The entry as the answer, wherever the origin is.
SlabAnswer entry_returned(const Ray& ray, const Box3d& box) {
  SlabAnswer answer = slab_swap_divide(ray, box);
  answer.t = answer.enter;
  return answer;
}

/// The 2-D test of the first chapter: only x and y, by pairs.
SlabAnswer pairwise_2d(const Ray& ray, const Box3d& box) {
  double txmin = (box.min.x - ray.origin.x) / ray.direction.x;
  double txmax = (box.max.x - ray.origin.x) / ray.direction.x;
  if (txmin > txmax) std::swap(txmin, txmax);
  double tymin = (box.min.y - ray.origin.y) / ray.direction.y;
  double tymax = (box.max.y - ray.origin.y) / ray.direction.y;
  if (tymin > tymax) std::swap(tymin, tymax);
  if (txmin > tymax || tymin > txmax) return {};
  const Span span{std::max(txmin, tymin), std::min(txmax, tymax)};
  return {in_limits(span, ray), span.enter >= ray.tmin ? span.enter : span.exit, span.enter,
          span.exit};
}

/// The interactive example of the Graphics Compendium (graphicscompendium.com, chapter 36,
/// "Boxes"), which is two-dimensional and JavaScript, with the third axis added: one NaN makes the
/// whole minimum or maximum NaN, which is then neither a miss nor positive. The text's -1 is our
/// miss.
SlabAnswer example_code_3d(const Ray& ray, const Box3d& box) {
  const auto larger = [](double a, double b) { return std::isnan(a) ? a : !(a > b) ? b : a; };
  const auto smaller = [](double a, double b) { return std::isnan(a) ? a : !(a < b) ? b : a; };
  double largest_min = -kInf;
  double smallest_max = kInf;
  for (int k = 0; k < 3; ++k) {
    double min = (box.min[k] - ray.origin[k]) / ray.direction[k];
    double max = (box.max[k] - ray.origin[k]) / ray.direction[k];
    if (min > max) std::swap(min, max);
    largest_min = larger(largest_min, min);
    smallest_max = smaller(smallest_max, max);
  }
  if (smallest_max < largest_min || smallest_max < 0) return {};
  return {true, largest_min > 0 ? largest_min : smallest_max, largest_min, smallest_max};
}

constexpr std::array<SlabTest, 12> kTests{{
    {"slab_swap_divide", "divide, swap, largest entry, smallest exit", slab_swap_divide},
    {"williams2005", "inverse and sign once per ray", williams2005},
    {"branchless_min_max", "min and max of both planes", branchless_min_max},
    {"fma_inverse", "one fused operation per plane", fma_inverse},
    {"ize2013_padded", "exit moved back by a constant factor", ize2013_padded},
    {"inverted_parallel", "mistake: the parallel test is inverted", inverted_parallel},
    {"slide_iteration_2", "mistake: the sign of the direction is lost", slide_iteration_2},
    {"d_ge_0", "mistake: -0 takes the branch of +0", d_ge_0},
    {"tgmin_positive", "mistake: an entry of 0 counts as behind", tgmin_positive},
    {"entry_returned", "mistake: the entry is the answer from inside", entry_returned},
    {"pairwise_2d", "pairs of slabs, x and y only", pairwise_2d},
    {"example_code_3d", "mistake: 0 / 0 silences the test for a miss", example_code_3d},
}};

}  // namespace

std::span<const SlabTest> slab_tests() { return kTests; }

const SlabTest& slab_test(std::string_view name) {
  return *std::find_if(kTests.begin(), kTests.end(),
                       [&](const SlabTest& test) { return test.name == name; });
}

}  // namespace sightline::contestants
