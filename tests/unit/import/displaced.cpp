#include "tests/unit/import/displaced.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/run/engine.h"
#include "tests/oracle/random.h"

namespace sightline::test {

namespace {

using Real = long double;  // so that the test's own rounding is far below what it judges

struct Vector {
  Real x = 0, y = 0, z = 0;
};
Vector minus(const Vec3d& a, const Vec3d& b) {
  return {Real{a.x} - Real{b.x}, Real{a.y} - Real{b.y}, Real{a.z} - Real{b.z}};
}
Real dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector cross_of(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vector minus(const Vector& a, const Vector& b, Real factor) {
  return {a.x - factor * b.x, a.y - factor * b.y, a.z - factor * b.z};
}
Real length(const Vector& a) { return std::sqrt(dot(a, a)); }

/// How far the line passes the segment, at the nearest.
Real distance(const Ray& ray, const Vec3d& a, const Vec3d& b) {
  // Seen along the line, it is the point 0.
  const Vector d = minus(ray.direction, {});
  const auto seen = [&](const Vec3d& p) {
    const Vector v = minus(p, ray.origin);
    return minus(v, d, dot(v, d) / dot(d, d));
  };
  const Vector p = seen(a), q = seen(b), edge = minus(q, p, 1);
  const Real square = dot(edge, edge);
  const Real at = square > 0 ? std::clamp(-dot(p, edge) / square, Real{0}, Real{1}) : 0;
  return length(minus(p, edge, -at));
}

Real distance_to_edges(const Ray& ray, const WorldTriangle& t) {
  return std::min(
      {distance(ray, t.v0, t.v1), distance(ray, t.v1, t.v2), distance(ray, t.v2, t.v0)});
}

/// How far t may move when the corners move so far.
Real slack(const Ray& ray, const WorldTriangle& t, Real moved) {
  const Vector n = cross_of(minus(t.v1, t.v0), minus(t.v2, t.v0));
  return moved * length(n) / std::fabs(dot(n, minus(ray.direction, {})));
}

/// Rounding of both scenes' float64 world positions, and of this judge: far below any displacement.
Real widened(double moved, const WorldTriangle& t) {
  Real size = 0;
  for (const Vec3d& p : {t.v0, t.v1, t.v2}) {
    size = std::max({size, std::fabs(Real{p.x}), std::fabs(Real{p.y}), std::fabs(Real{p.z})});
  }
  return Real{moved} + size * 0x1p-48L;
}

}  // namespace

std::string DisplacedTally::text() const {
  return std::to_string(rays) + " rays: " + std::to_string(hits) + " hits, " +
         std::to_string(same_bits) + " with equal bits of t, " + std::to_string(same_triangle) +
         " the same triangle (t differs by " + std::to_string(largest) + " at most), " +
         std::to_string(other_triangle) + " another triangle, " + std::to_string(hit_and_miss) +
         " hit against miss, " + std::to_string(unexplained) + " unexplained";
}

DisplacedTally compare_displaced(const DisplacedSurface& surface, const RayBatch& rays,
                                 const HitBatch& plain, const HitBatch& displaced,
                                 std::string& complaint) {
  DisplacedTally tally;
  tally.rays = rays.size();
  const auto complain = [&](std::size_t i, const std::string& what) {
    if (tally.unexplained++ == 0) complaint = "ray " + std::to_string(i) + ": " + what;
  };
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const bool hit = plain.hit(i), other_hit = displaced.hit(i);
    if (!hit && !other_hit) continue;
    ++tally.hits;
    const Ray ray = rays[i];
    const TriangleId a = hit ? plain.id(i) : TriangleId{};
    const TriangleId b = other_hit ? surface.origin_of(displaced.id(i)) : TriangleId{};
    const auto triangle = [&](TriangleId id) { return surface.plain.world_triangle(id); };
    const auto moved = [&](TriangleId id) { return widened(surface.moved(id), triangle(id)); };
    const auto passes_an_edge = [&](TriangleId id) {
      return distance_to_edges(ray, triangle(id)) <= moved(id);
    };
    if (hit != other_hit) {
      const TriangleId id = hit ? a : b;
      if (passes_an_edge(id)) {
        ++tally.hit_and_miss;
      } else {
        complain(i, "one hits, the other misses, far from any edge");
      }
      continue;
    }
    const Real apart = Real{displaced.t[i]} - Real{plain.t[i]};
    if (a == b) {
      if (std::fabs(apart) > slack(ray, triangle(a), moved(a))) {
        complain(i, "t differs by " + std::to_string(static_cast<double>(apart)));
        continue;
      }
      ++tally.same_triangle;
      if (apart == 0) ++tally.same_bits;
      tally.largest = std::max(
          tally.largest, static_cast<double>(std::fabs(apart) * length(minus(ray.direction, {}))));
      continue;
    }
    // Both triangles are met by both, and changed their order; or one is passed at an edge.
    const bool changed_order =
        -slack(ray, triangle(b), moved(b)) <= apart && apart <= slack(ray, triangle(a), moved(a));
    if (changed_order || passes_an_edge(a) || passes_an_edge(b)) {
      ++tally.other_triangle;
    } else {
      complain(i, "another triangle is hit, far from any edge");
    }
  }
  return tally;
}

RayBatch rays_at(const Box3d& box, std::size_t count, std::uint64_t seed) {
  oracle::Random random(seed);
  const auto between = [&](int axis, double beyond) {
    const double size = box.max[axis] - box.min[axis];
    return random.between(box.min[axis] - beyond * size, box.max[axis] + beyond * size);
  };
  RayBatch rays;
  while (rays.size() < count) {
    const Vec3d origin = {between(0, 2), between(1, 2), between(2, 2)};
    const Vec3d target = {between(0, 0.05), between(1, 0.05), between(2, 0.05)};
    const Vec3d direction = {target.x - origin.x, target.y - origin.y, target.z - origin.z};
    rays.push_back({origin, direction, 0, std::numeric_limits<double>::infinity()});
  }
  return rays;
}

HitBatch closest_of(const Scene& scene, const RayBatch& rays) {
  HitBatch hits;
  const auto engine = Engine::create({.threads = 1, .kernel = ""});
  if (engine) static_cast<void>((*engine)->closest(scene, rays, Deadline::never(), hits));
  return hits;
}

}  // namespace sightline::test
