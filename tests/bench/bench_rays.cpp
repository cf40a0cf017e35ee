#include "tests/bench/bench_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/demo/random.h"
#include "core/trace/kernel/kernel.h"

namespace sightline::bench {

namespace {

constexpr unsigned kColumns = 512;
constexpr unsigned kBeams = 128;

Vec3d add(const Vec3d& a, const Vec3d& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec3d sub(const Vec3d& a, const Vec3d& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec3d scale(double s, const Vec3d& a) { return {s * a.x, s * a.y, s * a.z}; }
double dot(const Vec3d& a, const Vec3d& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vec3d unit(const Vec3d& a) { return scale(1 / std::sqrt(dot(a, a)), a); }

HitBatch trace(const Scene& scene, const RayBatch& rays) {
  HitBatch hits;
  hits.resize(rays.size());
  TraceCounts counts;
  supported_kernels().front().closest(scene, rays, 0, rays.size(), hits, counts);
  return hits;
}

struct Place {
  Vec3d centre;
  Vec3d size;
  double diagonal;

  explicit Place(const Box3d& box)
      : centre(scale(0.5, add(box.min, box.max))),
        size(sub(box.max, box.min)),
        diagonal(std::sqrt(dot(size, size))) {}
};

/// Points on open ground near the middle: of 64 drawn places the 16 lowest.
std::vector<Vec3d> open_ground(const Scene& scene, const Place& place) {
  demo::Random random(11);
  RayBatch down;
  for (int i = 0; i < 64; ++i) {
    const double x = place.centre.x + place.size.x * random.between(-0.3, 0.3);
    const double z = place.centre.z + place.size.z * random.between(-0.3, 0.3);
    down.push_back({{x, place.centre.y + place.size.y, z}, {0, -1, 0}});
  }
  const HitBatch hits = trace(scene, down);
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const Ray ray = down[i];
    if (hits.hit(i)) points.push_back({ray.origin.x, ray.origin.y - hits.t[i], ray.origin.z});
  }
  std::sort(points.begin(), points.end(), [](const Vec3d& a, const Vec3d& b) { return a.y < b.y; });
  points.resize(std::min<std::size_t>(points.size(), 16));
  if (points.empty()) points.push_back(place.centre);
  return points;
}

struct View {
  Vec3d eye, target;
};

View view_of(const BenchScene& scene, const Place& place, unsigned index) {
  const double turn = 2 * std::numbers::pi * (index + 0.3) / 5;
  switch (scene.viewpoints) {
    case Viewpoints::kGround: {
      constexpr double kHeights[] = {0.002, 0.01, 0.03, 0.08, 0.15};
      const std::vector<Vec3d> ground = open_ground(*scene.scene, place);
      const Vec3d foot = ground[std::size_t{index} * 3 % ground.size()];
      const Vec3d eye = add(foot, {0, kHeights[index % 5] * place.diagonal, 0});
      return {eye, {place.centre.x, foot.y, place.centre.z}};
    }
    case Viewpoints::kInterior: {
      demo::Random random(21 + index);
      const auto spot = [&] {
        return add(place.centre, {place.size.x * random.between(-0.35, 0.35),
                                  place.size.y * random.between(-0.3, 0.1),
                                  place.size.z * random.between(-0.35, 0.35)});
      };
      const Vec3d eye = spot();
      return {eye, spot()};
    }
    case Viewpoints::kAround:
    case Viewpoints::kWithin:
      break;
  }
  const Vec3d direction = unit({std::cos(turn), 0.4, std::sin(turn)});
  // An object with air around it, or a volume that fills the picture.
  const double distance = scene.viewpoints == Viewpoints::kWithin ? 0.6 : 0.85;
  return {add(place.centre, scale(distance * place.diagonal, direction)), place.centre};
}

void add_view(const View& view, unsigned rows, RaySet& set) {
  const Vec3d forward = unit(sub(view.target, view.eye));
  const Vec3d right = unit(cross(forward, {0, 1, 0}));
  const Vec3d up = cross(right, forward);
  const double half = std::tan(std::numbers::pi / 6);
  const unsigned first = (kColumns - rows) / 2;
  for (unsigned row = first; row < first + rows; ++row) {
    const double y = half * (1 - 2 * (row + 0.5) / kColumns);
    for (unsigned column = 0; column < kColumns; ++column) {
      const double x = half * (2 * (column + 0.5) / kColumns - 1);
      set.push_back({view.eye, unit(add(forward, add(scale(x, right), scale(y, up))))});
    }
  }
}

RaySet camera_rays(const BenchScene& scene, const Place& place, const RayCounts& counts) {
  RaySet set{"camera", {}, {}};
  for (unsigned i = 0; i < counts.views; ++i) {
    add_view(view_of(scene, place, i), std::min(counts.rows, kColumns), set);
  }
  return set;
}

RaySet lidar_rays(const BenchScene& scene, const Place& place, const RayCounts& counts) {
  Vec3d sensor = place.centre;
  switch (scene.viewpoints) {
    case Viewpoints::kGround:
      sensor = add(open_ground(*scene.scene, place)[1], {0, 0.0015 * place.diagonal, 0});
      break;
    case Viewpoints::kAround:
      sensor.x += 0.6 * place.diagonal;
      break;
    case Viewpoints::kInterior:
      sensor = view_of(scene, place, 0).eye;
      break;
    case Viewpoints::kWithin:
      break;
  }
  RaySet set{"lidar", {}, {}};
  for (unsigned beam = 0; beam < kBeams; ++beam) {
    const double elevation = (15 - 40 * (beam + 0.5) / kBeams) * std::numbers::pi / 180;
    for (unsigned i = 0; i < counts.azimuths; ++i) {
      const double azimuth = 2 * std::numbers::pi * i / counts.azimuths;
      set.push_back({sensor,
                     {std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
                      std::cos(elevation) * std::sin(azimuth)}});
    }
  }
  return set;
}

/// Rays from the hits of `camera`: of each picture the middle rows, so that neighbours stay
/// neighbours, as many as fit.
RaySet ao_rays(const BenchScene& scene, const Place& place, const RaySet& camera,
               const RayCounts& counts) {
  demo::Random random(31);
  const std::size_t per_view = camera.size() / counts.views;
  const std::size_t rows_wanted = counts.others / counts.views / kColumns + 1;
  const std::size_t rows = std::min(rows_wanted, per_view / kColumns);
  const HitBatch hits = trace(*scene.scene, camera.rays);
  RaySet set{"ao", {}, {}};
  for (std::size_t view = 0; view < counts.views; ++view) {
    const std::size_t begin = view * per_view + (per_view / kColumns - rows) / 2 * kColumns;
    for (std::size_t i = begin; i < begin + rows * kColumns; ++i) {
      if (!hits.hit(i) || set.size() == counts.others) continue;
      const Ray ray = camera.rays[i];
      const WorldTriangle triangle = scene.scene->world_triangle(hits.id(i));
      Vec3d normal = unit(cross(sub(triangle.v1, triangle.v0), sub(triangle.v2, triangle.v0)));
      if (dot(normal, ray.direction) > 0) normal = scale(-1, normal);
      // A point of the unit sphere around the normal's tip: cosine distributed from its foot.
      const double z = random.between(-1, 1), turn = 2 * std::numbers::pi * random.unit();
      const double r = std::sqrt(1 - z * z);
      const Vec3d direction = add(normal, {r * std::cos(turn), r * std::sin(turn), z});
      if (!(dot(direction, direction) > 1e-6)) continue;
      // Off the surface, as a renderer does it; the limits of t count in unit length.
      const Vec3d point = add(ray.origin, scale(hits.t[i], ray.direction));
      set.push_back({add(point, scale(1e-5 * place.diagonal, normal)), unit(direction), 0,
                     0.08 * place.diagonal});
    }
  }
  return set;
}

RaySet incoherent_rays(const Place& place, const RayCounts& counts) {
  demo::Random random(41);
  RaySet set{"incoherent", {}, {}};
  for (unsigned i = 0; i < counts.others; ++i) {
    const Vec3d origin = add(place.centre, {place.size.x * random.between(-0.5, 0.5),
                                            place.size.y * random.between(-0.5, 0.5),
                                            place.size.z * random.between(-0.5, 0.5)});
    const double z = random.between(-1, 1), turn = 2 * std::numbers::pi * random.unit();
    const double r = std::sqrt(1 - z * z);
    set.push_back({origin, {r * std::cos(turn), r * std::sin(turn), z}});
  }
  return set;
}

}  // namespace

void RaySet::push_back(const Ray& ray) {
  // The float64 numbers are read back from memory: a compiler may not skip the rounding there.
  const std::array<double, 8> numbers = {ray.origin.x,    ray.origin.y,    ray.origin.z,
                                         ray.direction.x, ray.direction.y, ray.direction.z,
                                         ray.tmin,        ray.tmax};
  Column<float>* columns[] = {&floats.ox, &floats.oy, &floats.oz,   &floats.dx,
                              &floats.dy, &floats.dz, &floats.tmin, &floats.tmax};
  std::array<double, 8> rounded{};
  for (std::size_t k = 0; k < 8; ++k) {
    columns[k]->push_back(static_cast<float>(numbers[k]));
    rounded[k] = static_cast<double>(columns[k]->back());
  }
  rays.push_back({{rounded[0], rounded[1], rounded[2]},
                  {rounded[3], rounded[4], rounded[5]},
                  rounded[6],
                  rounded[7]});
}

std::vector<RaySet> make_ray_sets(const BenchScene& scene, const RayCounts& counts) {
  const Place place(scene.scene->bounds());
  std::vector<RaySet> sets;
  sets.push_back(camera_rays(scene, place, counts));
  sets.push_back(lidar_rays(scene, place, counts));
  sets.push_back(ao_rays(scene, place, sets[0], counts));
  sets.push_back(incoherent_rays(place, counts));
  return sets;
}

}  // namespace sightline::bench
