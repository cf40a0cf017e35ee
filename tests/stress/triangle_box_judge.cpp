#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/geometry/triangle_box.h"
#include "tests/oracle/box_oracle.h"
#include "tests/stress/triangle_box_cases.h"

namespace sightline::stress {

namespace {

bool meets(const oracle::Triangle& triangle, const oracle::ExactBox& box) {
  return !oracle::has_no_area(triangle) && oracle::overlap(box, triangle);
}

/// The box less a sliver, far below what any float64 could resolve.
oracle::ExactBox shrunk(oracle::ExactBox box, const oracle::Triangle& t) {
  mpq_class size = 0;
  for (const Vec3d* v : {&t.v0, &t.v1, &t.v2}) {
    for (int k = 0; k < 3; ++k) size = std::max(size, mpq_class(abs(mpq_class((*v)[k]))));
  }
  for (oracle::Slab& slab : box.slabs) {
    const mpq_class sliver =
        (abs(slab.normal[0]) + abs(slab.normal[1]) + abs(slab.normal[2])) * size * 0x1p-200;
    if (slab.low) *slab.low += sliver;
    if (slab.high) *slab.high -= sliver;
  }
  return box;
}

template <class Box>
TriangleBoxVerdict judge_box(const Triangle& triangle, const Box& box,
                             const oracle::ExactBox& exact) {
  const oracle::Triangle same{triangle.v0, triangle.v1, triangle.v2};
  TriangleBoxVerdict verdict;
  verdict.no_area = oracle::has_no_area(same);
  verdict.meets = meets(same, exact);
  verdict.touching = verdict.meets && !meets(same, shrunk(exact, same));
  const OverlapVerdict filter = filter_triangle_box(triangle, box);
  verdict.filtered = filter != OverlapVerdict::kOpen;
  if (triangle_meets_box(triangle, box) != verdict.meets) {
    verdict.fault = verdict.meets ? "false miss" : "false hit";
  } else if (verdict.filtered && (filter == OverlapVerdict::kMeet) != verdict.meets) {
    verdict.fault = "the filter is wrong";
  } else if (exact_triangle_box(triangle, box) != verdict.meets) {
    verdict.fault = "the exact stage is wrong";
  }
  return verdict;
}

}  // namespace

TriangleBoxVerdict judge(const TriangleBoxCase& test) {
  if (!test.oriented) {
    return judge_box(test.triangle, test.aligned, oracle::axis_aligned(test.aligned));
  }
  const OrientedBox& box = *test.oriented;
  return judge_box(test.triangle, box, oracle::oriented_by_slabs(box.center, box.axes, box.half));
}

std::string describe(const TriangleBoxCase& test) {
  std::ostringstream out;
  out << std::hexfloat;
  const auto put = [&](const char* name, const Vec3d& v) {
    out << name << " {" << v.x << ", " << v.y << ", " << v.z << "} ";
  };
  put("v0", test.triangle.v0);
  put("v1", test.triangle.v1);
  put("v2", test.triangle.v2);
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
