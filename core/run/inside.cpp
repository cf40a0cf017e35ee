#include "core/run/inside.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "core/run/engine.h"
#include "core/run/engine_state.h"
#include "core/run/resolved_filter.h"
#include "core/run/world_edges.h"

namespace sightline {

namespace {

/// Along no axis and in no diagonal plane, where what people build has its walls.
constexpr std::array<Vec3d, 3> kDirections{Vec3d{0.8125, 0.28125, 0.515625},
                                           Vec3d{-0.34375, 0.90625, -0.234375},
                                           Vec3d{-0.421875, -0.578125, 0.703125}};

RayBatch rays_from(const Column<Vec3d>& points, const Vec3d& direction) {
  RayBatch rays;
  rays.reserve(points.size());
  for (const Vec3d& point : points) rays.push_back({point, direction});
  return rays;
}

/// Retains the instances, but of their sides only these.
ResolvedFilter only(const ResolvedFilter& resolved, std::uint8_t sides) {
  ResolvedFilter some = resolved;
  for (std::uint8_t& its : some.sides) its = its & sides;
  return some;
}

}  // namespace

Status Engine::inside(const Scene& scene, const Column<Vec3d>& points, InsideMethod method,
                      const Deadline& deadline, InsideAnswers& answers,
                      const RayOptions& options) const try {
  const std::size_t n = points.size();
  const ReserveBytes& reserve = options.reserve;
  const bool by_angle = method == InsideMethod::kSolidAngle,
             by_sides = method != InsideMethod::kParity;
  std::vector<OpenEdge> edges;
  if (by_angle) {
    auto found = open_edges_in_world(scene, options.resolved, deadline, reserve);
    if (!found) return std::move(found).error();
    edges = std::move(*found);
    answers.open_edges = 0;
  } else {
    auto open = open_edges(scene, options.resolved, method, deadline, reserve);
    if (!open) return std::move(open).error();
    answers.open_edges = *open;
  }
  answers.inside.assign(n, 0);
  answers.reliable.assign(n, 1);
  answers.winding.assign(by_sides ? n : 0, 0);
  answers.generalized.assign(by_angle ? n : 0, 0);
  answers.error.assign(by_angle ? n : 0, std::numeric_limits<double>::infinity());

  // On the surface: the ray that is the point alone meets something.
  RayBatch rays = rays_from(points, kDirections[0]);
  rays.tmax.assign(n, 0);
  if (Status status = any(scene, rays, deadline, answers.on_surface, options); !status) {
    return status;
  }

  std::optional<ResolvedFilter> fronts, backs;
  if (by_sides) {
    if (Status status = ask_for(reserve, 2 * resolved_filter_bytes(scene)); !status) return status;
    std::optional<ResolvedFilter> all;  // of no filter
    if (options.resolved == nullptr) {
      auto found = resolve_filter(scene, {}, deadline, reserve);
      if (!found) return std::move(found).error();
      all = std::move(*found);
    }
    const ResolvedFilter& sides = all ? *all : *options.resolved;
    fronts = only(sides, ResolvedFilter::kFront);
    backs = only(sides, ResolvedFilter::kBack);
  }
  Column<std::uint64_t> totals, minus;
  for (std::size_t k = 0; k < kDirections.size(); ++k) {
    rays = rays_from(points, kDirections[k]);
    RayOptions counted = options;
    if (backs) counted.resolved = &*backs;
    Status status = count(scene, rays, Crossings::kOnce, deadline, totals, counted);
    if (status && fronts) {
      counted.resolved = &*fronts;
      status = count(scene, rays, Crossings::kOnce, deadline, minus, counted);
    }
    if (!status) return status;
    if (by_angle) {
      // Along another direction only where the ray passes by open edges too closely.
      const double enough = 0x1p-40 * static_cast<double>(1 + edges.size());
      std::atomic<bool> is_enough{true};
      const auto slice = [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          if (answers.on_surface[i] != 0 || answers.error[i] <= enough) continue;
          const BoundedNumber open = winding_of_open_edges(edges, points[i], kDirections[k]);
          if (!(open.error < answers.error[i])) continue;
          answers.generalized[i] =
              static_cast<double>(totals[i]) - static_cast<double>(minus[i]) + open.value;
          answers.error[i] = open.error + 0x1p-52 * std::fabs(answers.generalized[i]);
          if (edges.empty()) answers.error[i] = 0;
          if (answers.error[i] > enough) is_enough.store(false);
        }
      };
      status = state_->run(n, deadline, slice, 1 + 4096 / (1 + edges.size()));
      if (!status) return status;
      if (is_enough.load()) break;
      continue;
    }
    for (std::size_t i = 0; i < n; ++i) {
      const auto winding =
          static_cast<std::int64_t>(totals[i]) - static_cast<std::int64_t>(fronts ? minus[i] : 0);
      const std::uint8_t inside = (fronts ? winding != 0 : totals[i] % 2 != 0) ? 1 : 0;
      const bool same = fronts ? winding == answers.winding[i] : inside == answers.inside[i];
      if (k == 0) {
        answers.inside[i] = inside;
        if (fronts) answers.winding[i] = winding;
      } else if (!same) {
        answers.reliable[i] = 0;
      }
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (by_angle) {
      const double beyond = std::fabs(answers.generalized[i]) - 0.5;
      answers.inside[i] = beyond > 0 ? 1 : 0;
      answers.reliable[i] = std::fabs(beyond) > answers.error[i] ? 1 : 0;
    }
    if (answers.on_surface[i] == 0) continue;
    if (by_angle) {
      answers.generalized[i] = std::numeric_limits<double>::quiet_NaN();
      answers.error[i] = 0;
    }
    answers.inside[i] = 0;
    answers.reliable[i] = 1;
    if (fronts) answers.winding[i] = 0;
  }
  if (by_angle) answers.winding.clear();
  return success();
} catch (const std::bad_alloc&) {
  return Error{ErrorKind::kOutOfSpace, "MEMORY_EXHAUSTED", "there is no memory for the answer", ""};
}

Result<std::uint64_t> open_edges(const Scene& scene, const ResolvedFilter* resolved,
                                 InsideMethod method, const Deadline& deadline,
                                 const ReserveBytes& reserve) {
  const SceneDescription& description = scene.description();
  // One mesh after the other uses the same memory.
  std::uint64_t most = 0;
  const ReserveBytes reserve_more = [&](std::uint64_t bytes) {
    Status status = bytes > most ? ask_for(reserve, bytes - most) : success();
    if (status) most = std::max(most, bytes);
    return status;
  };
  // The edges of meshes of which some primitives count, for each set of these: most placements of a
  // mesh have one set.
  std::map<std::pair<std::uint32_t, std::vector<bool>>, OpenEdges> parts;
  DeadlineWatch watch(deadline);
  std::uint64_t open = 0;
  for (std::size_t i = 0; i < description.instances.size(); ++i) {
    const std::uint32_t number = description.instances[i].mesh;
    const Mesh& mesh = *description.meshes[number];
    if (watch.passed(1 + mesh.primitives.size())) return watch.error();
    if (description.instances[i].hidden) continue;
    const std::vector<bool> counts = counting_primitives(scene, i, resolved);
    const auto chosen = std::count(counts.begin(), counts.end(), true);
    if (chosen == 0) continue;
    OpenEdges edges;
    if (static_cast<std::size_t>(chosen) == counts.size()) {
      auto found = scene.open_edges(number, deadline, reserve_more);
      if (!found) return std::move(found).error();
      edges = *found;
    } else if (const auto known = parts.find({number, counts}); known != parts.end()) {
      edges = known->second;
    } else {
      const auto is_chosen = [&](std::size_t primitive) { return counts[primitive]; };
      if (Status status = reserve_more(open_edges_bytes(mesh, is_chosen)); !status)
        return std::move(status).error();
      auto found = sightline::open_edges(mesh, is_chosen, deadline);
      if (!found) return std::move(found).error();
      // A mesh has few such parts: nodes choose all of it or nothing, only materials choose more.
      constexpr std::uint64_t kPartBytes = 160;
      if (Status status = ask_for(reserve, kPartBytes + counts.size() / 8); !status)
        return std::move(status).error();
      parts.emplace(std::pair(number, counts), *found);
      edges = *found;
    }
    open += method == InsideMethod::kWinding ? edges.unbalanced : edges.unpaired;
  }
  return open;
}

Status Engine::signed_distances(const Scene& scene, const Column<Vec3d>& points,
                                InsideMethod method, double max_distance, const Deadline& deadline,
                                InsideAnswers& answers, const RayOptions& options) const {
  HitBatch hits;
  Status status = nearest(scene, points, max_distance, 1, deadline, hits, options);
  if (status) status = inside(scene, points, method, deadline, answers, options);
  if (!status) return status;
  answers.distance = std::move(hits.t);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (answers.inside[i] != 0) answers.distance[i] = -answers.distance[i];
  return success();
}

}  // namespace sightline
