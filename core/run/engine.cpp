#include "core/run/engine.h"

#include <cmath>
#include <limits>

// First stand-in for the traversal kernels, so that the rooms above can be built: every ray against
// every triangle in plain float64. Replaced by core/trace.

namespace sightline {

struct Engine::State {
  std::string kernel = "brute";
};

Engine::Engine(std::unique_ptr<State> state) : state_(std::move(state)) {}
Engine::~Engine() = default;
std::vector<std::string> Engine::kernels() { return {"brute"}; }
const std::string& Engine::kernel() const { return state_->kernel; }
int Engine::threads() const { return 1; }

Result<std::unique_ptr<Engine>> Engine::create(const EngineOptions&) {
  return std::unique_ptr<Engine>(new Engine(std::make_unique<State>()));
}

Status Engine::closest(const Scene& scene, const RayBatch& rays, const Deadline& deadline,
                       HitBatch& hits) const {
  hits.resize(rays.size());
  const auto& instances = scene.description().instances;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (deadline.passed()) return Error{ErrorKind::kDeadline, "DEADLINE", "out of time", ""};
    const Ray ray = rays[i];
    hits.t[i] = std::numeric_limits<double>::infinity();
    hits.instance[i] = hits.triangle[i] = kNone;
    for (std::uint32_t k = 0; k < instances.size(); ++k) {
      const std::uint32_t count = scene.description().meshes[instances[k].mesh]->triangle_count();
      for (std::uint32_t j = 0; j < count; ++j) {
        const WorldTriangle w = scene.world_triangle({k, j});
        const double e1[3] = {w.v1.x - w.v0.x, w.v1.y - w.v0.y, w.v1.z - w.v0.z};
        const double e2[3] = {w.v2.x - w.v0.x, w.v2.y - w.v0.y, w.v2.z - w.v0.z};
        const double s[3] = {ray.origin.x - w.v0.x, ray.origin.y - w.v0.y, ray.origin.z - w.v0.z};
        const Vec3d& d = ray.direction;
        const double p[3] = {d.y * e2[2] - d.z * e2[1], d.z * e2[0] - d.x * e2[2],
                             d.x * e2[1] - d.y * e2[0]};
        const double q[3] = {s[1] * e1[2] - s[2] * e1[1], s[2] * e1[0] - s[0] * e1[2],
                             s[0] * e1[1] - s[1] * e1[0]};
        const double det = e1[0] * p[0] + e1[1] * p[1] + e1[2] * p[2];
        const double u = (s[0] * p[0] + s[1] * p[1] + s[2] * p[2]) / det;
        const double v = (d.x * q[0] + d.y * q[1] + d.z * q[2]) / det;
        const double t = (e2[0] * q[0] + e2[1] * q[1] + e2[2] * q[2]) / det;
        if (u >= 0 && v >= 0 && u + v <= 1 && t >= ray.tmin && t <= ray.tmax && t < hits.t[i]) {
          hits.t[i] = t;
          hits.instance[i] = k;
          hits.triangle[i] = j;
        }
      }
    }
  }
  return success();
}

Status Engine::any(const Scene& scene, const RayBatch& rays, const Deadline& deadline,
                   Column<std::uint8_t>& occluded) const {
  HitBatch hits;
  if (Status status = closest(scene, rays, deadline, hits); !status) return status;
  occluded.resize(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) occluded[i] = hits.hit(i) ? 1 : 0;
  return success();
}

Status Engine::details(const Scene& scene, const RayBatch& rays, const HitBatch& hits,
                       const Deadline&, Column<HitDetail>& out) const {
  out.assign(rays.size(), {});
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!hits.hit(i)) continue;
    const Ray ray = rays[i];
    const double t = hits.t[i];
    const WorldTriangle w = scene.world_triangle(hits.id(i));
    const double e1[3] = {w.v1.x - w.v0.x, w.v1.y - w.v0.y, w.v1.z - w.v0.z};
    const double e2[3] = {w.v2.x - w.v0.x, w.v2.y - w.v0.y, w.v2.z - w.v0.z};
    Vec3d n{e1[1] * e2[2] - e1[2] * e2[1], e1[2] * e2[0] - e1[0] * e2[2],
            e1[0] * e2[1] - e1[1] * e2[0]};
    const double length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    out[i].normal = {n.x / length, n.y / length, n.z / length};
    out[i].position = {ray.origin.x + t * ray.direction.x, ray.origin.y + t * ray.direction.y,
                       ray.origin.z + t * ray.direction.z};
  }
  return success();
}

}  // namespace sightline
