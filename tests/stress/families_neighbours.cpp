// Rays that run side by side, as a picture's do, each at a place where arithmetic is hard: what is
// decided for many rays at once must be right for each.

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/stress/aims.h"
#include "tests/stress/meshes.h"

namespace sightline::stress {
namespace {

/// Orders directions row by row, as a picture does.
void sort_into_rows(std::vector<Vec3d>& directions) {
  const auto rows = std::sqrt(static_cast<double>(directions.size()));
  const auto key = [&](const Vec3d& d) {
    const double r = length(d);
    return std::pair(std::floor(rows * d.y / r), d.x / r);
  };
  std::sort(directions.begin(), directions.end(),
            [&](const Vec3d& a, const Vec3d& b) { return key(a) < key(b); });
}

Case picture_of_corners(Random& random, std::size_t count) {
  const bool placed = random.chance(0.5);
  Case result{scene_of({scan(random, 6000)}, {placed ? rotation(random) : Affine{}}), {}, true};
  const Aim aim(result.scene, random);
  constexpr std::size_t kPicture = 1000;
  while (result.rays.size() < count) {
    const Vec3d eye = as_float32(plus(aim.middle(), 1.5 * aim.size(), random.direction()));
    std::vector<Vec3d> directions;
    for (std::size_t i = 0; i < std::min(kPicture, count - result.rays.size()); ++i) {
      const double kind = random.between(0, 1);
      const Vec3d target =
          kind < 0.4 ? aim.corner() : (kind < 0.8 ? aim.edge_point() : aim.inner_point());
      directions.push_back(minus(target, eye));
    }
    sort_into_rows(directions);
    for (const Vec3d& direction : directions) {
      Ray ray{eye, direction};
      // Some end at what they aim at, to the last bit or one number before.
      if (random.chance(0.2)) ray.tmax = random.chance(0.5) ? 1 : std::nextafter(1.0, 0.0);
      ensure_valid(ray);
      result.rays.push_back(ray);
    }
  }
  return result;
}

Case sheets_through_cubes(Random& random, std::size_t count) {
  constexpr int kCubes = 5, kSteps = 8;
  Case result{scene_of(stacked_cubes(kCubes)), {}, true};
  const std::array<Vec3d, 6> ways{
      {{1, 2, 4}, {-1, 1, 1}, {0, 1, -1}, {0, -0.0, 1}, {-2, 0, 0}, {1, -3, 0}}};
  while (result.rays.size() < count) {
    // Parallel rays through the points of a lattice in a plane across the stack.
    const Vec3d& way = ways[static_cast<std::size_t>(random.integer(0, 5))];
    const int across = random.integer(0, 2);
    const double level = 0.5 * random.integer(0, 2 * kCubes);
    for (int row = 0; row <= kCubes * kSteps; row += random.integer(1, kSteps)) {
      for (int i = 0; i <= kCubes * kSteps && result.rays.size() < count; ++i) {
        Vec3d at;
        at[across] = level;
        at[(across + 1) % 3] = static_cast<double>(row) / kSteps;
        at[(across + 2) % 3] = static_cast<double>(i) / kSteps;
        result.rays.push_back({plus(at, -8, way), way});
      }
    }
  }
  return result;
}

}  // namespace

std::vector<Family> neighbour_families() {
  return {
      {"picture_of_corners", "pictures whose rays aim at corners and edges", picture_of_corners},
      {"sheets_through_cubes", "parallel rays on a lattice through stacked cubes",
       sheets_through_cubes},
  };
}

}  // namespace sightline::stress
