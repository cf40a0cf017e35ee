#include <algorithm>
#include <atomic>
#include <limits>

#include "core/run/alpha_cutoff.h"
#include "core/run/engine_state.h"
#include "core/run/group_rounds.h"
#include "core/run/grouped_rays.h"
#include "core/run/unbuilt_rounds.h"
#include "core/trace/decision.h"

namespace sightline {

/// The limit of a ray that needs no further tree.
static constexpr double kNever = std::numeric_limits<double>::quiet_NaN();

Engine::Engine(std::unique_ptr<State> state) : state_(std::move(state)) {}
Engine::~Engine() = default;

std::vector<std::string> Engine::kernels() {
  std::vector<std::string> names;
  for (const Kernel& kernel : supported_kernels()) names.emplace_back(kernel.name);
  return names;
}

const std::string& Engine::kernel() const { return state_->kernel_name; }
int Engine::threads() const { return state_->threads.threads(); }

Result<std::unique_ptr<Engine>> Engine::create(const EngineOptions& options) {
  auto state = std::make_unique<State>();
  const std::vector<Kernel> kernels = supported_kernels();
  const auto chosen = std::find_if(kernels.begin(), kernels.end(), [&](const Kernel& kernel) {
    return options.kernel.empty() || kernel.name == options.kernel;
  });
  if (chosen == kernels.end()) {
    std::string known;
    for (const std::string& name : Engine::kernels()) known += (known.empty() ? "" : ", ") + name;
    return Error{ErrorKind::kInvalid, "ENGINE_KERNEL_UNKNOWN",
                 "kernel '" + options.kernel + "' is not one that this machine runs: " + known, ""};
  }
  state->kernel = *chosen;
  state->kernel_name = std::string(chosen->name);
  state->should_yield = options.should_yield;
  state->threads.start(options.threads);
  state->turns.start(state->threads.threads());
  // A batch has many slices; a single ray is answered on the thread that asks.
  state->threads.give_way();
  return std::unique_ptr<Engine>(new Engine(std::move(state)));
}

Status Engine::closest(const Scene& scene, const RayBatch& rays, const Deadline& deadline,
                       HitBatch& hits, const RayOptions& options) const {
  if (!options.groups.empty()) {
    return within_memory(
        [&] { return GroupedRays(*this, scene, deadline, options).closest(rays, hits); });
  }
  if (options.alpha_cutoff) {
    return within_memory(
        [&] { return AlphaCutoff(*this, scene, deadline, options).closest(rays, hits); });
  }
  const SceneTrees::Use use(scene.trees());
  WorkLog log(scene, options.work);
  return within_memory([&]() -> Status {
    hits.resize(rays.size());
    const auto slice = [&](const SceneView& view, const RayBatch& some, std::size_t begin,
                           std::size_t end, HitBatch& found) {
      TraceCounts counts{&deadline};
      const WorkLog::Entry entry(log, counts);
      if (options.resolved != nullptr) {
        state_->kernel.closest_filtered(view, some, begin, end, *options.resolved, found, counts);
      } else {
        state_->kernel.closest(view, some, begin, end, found, counts);
      }
    };
    const auto trace = [&](const SceneView& view, const RayBatch& some, HitBatch& found) {
      if (auto groups = TreeGroups::of(view, some)) {
        const ClosestOfGroups closest(scene, some, found);
        const auto limit = [&](std::size_t i) { return closest.limit(i); };
        const auto add = [&](const SceneView& trees, const RayBatch& rays_of_group,
                             std::span<const std::size_t> numbers) {
          HitBatch hits_of_group;
          hits_of_group.resize(numbers.size());
          slice(trees, rays_of_group, 0, numbers.size(), hits_of_group);
          closest.add(hits_of_group, numbers);
        };
        return log.checked(state_->by_groups(*groups, some, deadline, limit, add), deadline);
      }
      Status traced = state_->run(some.size(), deadline, [&](std::size_t begin, std::size_t end) {
        slice(view, some, begin, end, found);
      });
      return log.checked(std::move(traced), deadline);
    };
    const SceneView view(scene);
    Status status = trace(view, rays, hits);
    if (!status || view.tree().complete()) return status;
    if (!options.builds) return trees_are_unbuilt();
    return state_->trace_again(
        view, rays.size(), deadline,
        [&](UnbuiltTrees& unbuilt, std::span<const std::size_t> numbers, std::uint32_t* next) {
          unbuilt.nearest(
              rays, numbers, [&](std::size_t i) { return hits.t[i]; }, next);
        },
        [&](const SceneView& later, std::span<const std::size_t> numbers) -> Status {
          HitBatch found;
          found.resize(numbers.size());
          Status again = trace(later, rays_of(rays, numbers), found);
          for (std::size_t i = 0; i < numbers.size(); ++i) {
            hits.copy(found, i, numbers[i]);
          }
          return again;
        });
  });
}

Status Engine::any(const Scene& scene, const RayBatch& rays, const Deadline& deadline,
                   Column<std::uint8_t>& occluded, const RayOptions& options) const {
  if (!options.groups.empty()) {
    return within_memory(
        [&] { return GroupedRays(*this, scene, deadline, options).any(rays, occluded); });
  }
  if (options.alpha_cutoff) {
    return within_memory(
        [&] { return AlphaCutoff(*this, scene, deadline, options).any(rays, occluded); });
  }
  const SceneTrees::Use use(scene.trees());
  WorkLog log(scene, options.work);
  return within_memory([&]() -> Status {
    occluded.resize(rays.size());
    const auto slice = [&](const SceneView& view, const RayBatch& some, std::size_t begin,
                           std::size_t end, std::uint8_t* found) {
      TraceCounts counts{&deadline};
      const WorkLog::Entry entry(log, counts);
      if (options.resolved != nullptr) {
        state_->kernel.any_filtered(view, some, begin, end, *options.resolved, found, counts);
      } else {
        state_->kernel.any(view, some, begin, end, found, counts);
      }
    };
    const auto trace = [&](const SceneView& view, const RayBatch& some, std::uint8_t* found) {
      if (auto groups = TreeGroups::of(view, some)) {
        std::fill_n(found, some.size(), std::uint8_t{0});
        const auto limit = [&](std::size_t i) { return found[i] != 0 ? kNever : some.tmax[i]; };
        const auto add = [&](const SceneView& trees, const RayBatch& rays_of_group,
                             std::span<const std::size_t> numbers) {
          Column<std::uint8_t> met(numbers.size());
          slice(trees, rays_of_group, 0, numbers.size(), met.data());
          for (std::size_t k = 0; k < numbers.size(); ++k) found[numbers[k]] |= met[k];
        };
        return log.checked(state_->by_groups(*groups, some, deadline, limit, add), deadline);
      }
      Status traced = state_->run(some.size(), deadline, [&](std::size_t begin, std::size_t end) {
        slice(view, some, begin, end, found);
      });
      return log.checked(std::move(traced), deadline);
    };
    const SceneView view(scene);
    Status status = trace(view, rays, occluded.data());
    if (!status || view.tree().complete()) return status;
    if (!options.builds) return trees_are_unbuilt();
    return state_->trace_again(
        view, rays.size(), deadline,
        [&](UnbuiltTrees& unbuilt, std::span<const std::size_t> numbers, std::uint32_t* next) {
          const auto limit = [&](std::size_t i) {
            return occluded[i] != 0 ? kNever : rays.tmax[i];
          };
          unbuilt.nearest(rays, numbers, limit, next);
        },
        [&](const SceneView& later, std::span<const std::size_t> numbers) -> Status {
          Column<std::uint8_t> found(numbers.size());
          Status again = trace(later, rays_of(rays, numbers), found.data());
          for (std::size_t i = 0; i < numbers.size(); ++i) occluded[numbers[i]] = found[i];
          return again;
        });
  });
}

Status Engine::count(const Scene& scene, const RayBatch& rays, Crossings crossings,
                     const Deadline& deadline, Column<std::uint64_t>& totals,
                     const RayOptions& options) const {
  if (!options.groups.empty()) {
    return within_memory([&] {
      return GroupedRays(*this, scene, deadline, options).count(rays, crossings, totals);
    });
  }
  if (options.alpha_cutoff) {
    return within_memory([&] {
      return AlphaCutoff(*this, scene, deadline, options).count(rays, crossings, totals);
    });
  }
  const SceneTrees::Use use(scene.trees());
  WorkLog log(scene, options.work);
  return within_memory([&]() -> Status {
    totals.resize(rays.size());
    const auto met = [&](UnbuiltTrees& unbuilt, std::size_t i, std::vector<std::uint32_t>& trees) {
      unbuilt.met(rays[i], trees);
    };
    if (!options.builds && !SceneView(scene).tree().complete()) return trees_are_unbuilt();
    const auto view = state_->with_trees(scene, rays.size(), deadline, met);
    if (!view) return view.error();
    const auto slice = [&](std::size_t begin, std::size_t end) {
      TraceCounts counts{&deadline};
      const WorkLog::Entry entry(log, counts);
      state_->all(*view, rays, begin, end, options, {crossings, 0, totals.data(), nullptr}, counts);
    };
    return log.checked(state_->run(rays.size(), deadline, slice, kListSlice), deadline);
  });
}

Status Engine::all(const Scene& scene, const RayBatch& rays, const HitListQuestion& question,
                   const Deadline& deadline, HitLists& lists, Column<std::uint64_t>& totals,
                   const RayOptions& options) const {
  if (!options.groups.empty()) {
    return within_memory([&] {
      return GroupedRays(*this, scene, deadline, options).all(rays, question, lists, totals);
    });
  }
  if (options.alpha_cutoff) {
    return within_memory([&] {
      return AlphaCutoff(*this, scene, deadline, options).all(rays, question, lists, totals);
    });
  }
  const SceneTrees::Use use(scene.trees());
  WorkLog log(scene, options.work);
  return within_memory([&]() -> Status {
    // Every slice fills a list of its own; they are joined in the order of rays.
    std::vector<HitBatch> slices((rays.size() + kListSlice - 1) / kListSlice);
    std::atomic<std::size_t> gathered{0};
    totals.assign(rays.size(), 0);
    const auto met = [&](UnbuiltTrees& unbuilt, std::size_t i, std::vector<std::uint32_t>& trees) {
      unbuilt.met(rays[i], trees);
    };
    const auto view = state_->with_trees(scene, rays.size(), deadline, met);
    if (!view) return view.error();
    const auto gather = [&](std::size_t begin, std::size_t end) {
      TraceCounts counts{&deadline};
      const WorkLog::Entry entry(log, counts);
      HitBatch& slice = slices[begin / kListSlice];
      // One by one: beyond the limit there is at most one ray's list for each thread.
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t before = gathered.load(std::memory_order_relaxed);
        if (before > question.total_max) return;
        // A longer list than all may still have is an error: its end need not be resolved.
        const std::size_t most = std::min(question.each_max, question.total_max - before);
        state_->all(*view, rays, i, i + 1, options,
                    {question.crossings, most, totals.data(), &slice}, counts);
        gathered.fetch_add(std::min<std::size_t>(totals[i], question.each_max),
                           std::memory_order_relaxed);
      }
    };
    Status status = log.checked(state_->run(rays.size(), deadline, gather, kListSlice), deadline);
    if (!status) return status;
    if (gathered.load() > question.total_max) {
      return Error{ErrorKind::kTooLarge, "TOO_MANY_HITS",
                   "the rays meet more than " + std::to_string(question.total_max) +
                       " triangles; send fewer rays or a smaller max_hits",
                   ""};
    }

    lists.first.assign(1, 0);
    lists.first.reserve(rays.size() + 1);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      lists.first.push_back(lists.first.back() +
                            std::min<std::size_t>(totals[i], question.each_max));
    }
    lists.hits.resize(0);
    for (const HitBatch& slice : slices) lists.hits.append(slice);
    return success();
  });
}

Status Engine::costs(const Scene& scene, const RayBatch& rays, const Deadline& deadline,
                     RayCosts& costs, const RayOptions& options) const {
  const SceneTrees::Use use(scene.trees());
  WorkLog log(scene, nullptr);
  return within_memory([&]() -> Status {
    const SceneView view(scene);
    HitBatch found;
    found.resize(rays.size());
    costs.nodes.resize(rays.size());
    costs.blocks.resize(rays.size());
    const auto trace = [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        TraceCounts counts{&deadline};
        const WorkLog::Entry entry(log, counts);
        if (options.resolved != nullptr) {
          state_->kernel.closest_filtered(view, rays, i, i + 1, *options.resolved, found, counts);
        } else {
          state_->kernel.closest(view, rays, i, i + 1, found, counts);
        }
        costs.nodes[i] = static_cast<std::uint32_t>(counts.nodes + counts.packet_nodes);
        costs.blocks[i] = static_cast<std::uint32_t>(counts.blocks);
      }
    };
    return log.checked(state_->run(rays.size(), deadline, trace), deadline);
  });
}

Status Engine::details(const Scene& scene, const RayBatch& rays, const HitBatch& hits,
                       const Deadline& deadline, Column<HitDetail>& out) const {
  return within_memory([&]() -> Status {
    out.assign(rays.size(), {});
    return state_->run(rays.size(), deadline, [&](std::size_t begin, std::size_t end) {
      TraceCounts counts;
      state_->kernel.details(scene, rays, begin, end, hits, out.data(), counts);
    });
  });
}

Status Engine::normals(const Scene& scene, const HitBatch& hits, const Deadline& deadline,
                       Column<Vec3d>& out) const {
  return within_memory([&]() -> Status {
    out.assign(hits.size(), {});
    return state_->run(hits.size(), deadline, [&](std::size_t begin, std::size_t end) {
      state_->kernel.normals(scene, begin, end, hits, out.data());
    });
  });
}

Status Engine::mark_edges(const Scene& scene, const RayBatch& rays, const HitBatch& hits,
                          const Deadline& deadline, Column<HitDetail>& details) const {
  return state_->run(rays.size(), deadline, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (hits.hit(i)) details[i].on_edge = hit_on_edge(scene, rays[i], hits.id(i), details[i]);
    }
  });
}

}  // namespace sightline
