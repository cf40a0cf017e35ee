#pragma once
/// How an engine handles unbuilt trees: it finds the trees that an answer needs, lets the scene
/// build them, and traces again. Only the calling thread waits for a tree, and never inside of
/// parallel work: otherwise it could wait for a tree that it was itself to build.

#include <algorithm>
#include <mutex>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "core/run/engine_state.h"
#include "core/trace/search/unbuilt.h"

namespace sightline {

/// Copies the rays with these indices, and their masks, into a new batch.
inline RayBatch rays_of(const RayBatch& rays, std::span<const std::size_t> numbers) {
  RayBatch some;
  some.reserve(numbers.size());
  for (const std::size_t i : numbers) {
    some.push_back(rays[i]);
    if (!rays.mask.empty()) some.mask.push_back(rays.mask[i]);
  }
  return some;
}

/// The nodes with unbuilt trees below them, if so many queries search for these trees that it pays.
inline std::optional<UnbuiltNodes> unbuilt_nodes(const SceneView& view, std::size_t queries) {
  std::optional<UnbuiltNodes> nodes;
  if (queries >= UnbuiltNodes::kManyQueries) nodes.emplace(view);
  return nodes;
}

/// Sorts indices and removes duplicates.
inline void sort_and_merge(std::vector<std::uint32_t>& trees) {
  std::sort(trees.begin(), trees.end());
  trees.erase(std::unique(trees.begin(), trees.end()), trees.end());
}

template <class Find>
Result<SceneView> Engine::State::with_trees(const Scene& scene, std::size_t count,
                                            const Deadline& deadline, Find find) {
  SceneView view(scene);
  bool counted = false;
  while (!view.tree().complete()) {
    std::mutex mutex;
    std::vector<std::uint32_t> wanted;
    std::size_t waiting = 0;
    const auto nodes = unbuilt_nodes(view, count);
    const auto look = [&](std::size_t begin, std::size_t end) {
      UnbuiltTrees unbuilt(view, nodes ? &*nodes : nullptr);
      std::vector<std::uint32_t> trees;
      std::size_t wanting = 0;
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t before = trees.size();
        find(unbuilt, i, trees);
        wanting += trees.size() > before ? 1u : 0u;
        // Many queries may need the same few trees.
        if (trees.size() > 2 * view.tree().trees.size()) sort_and_merge(trees);
      }
      sort_and_merge(trees);
      const std::lock_guard hold(mutex);
      wanted.insert(wanted.end(), trees.begin(), trees.end());
      waiting += wanting;
    };
    if (Status status = run(count, deadline, look); !status) return std::move(status).error();
    if (wanted.empty()) break;
    if (!counted) scene.trees().count_waiting(waiting);
    counted = true;
    sort_and_merge(wanted);
    auto tree = scene.trees().build(view.shared_tree(), wanted, deadline, threads);
    if (!tree) return std::move(tree).error();
    view = SceneView(scene, std::move(*tree));
  }
  return view;
}

template <class Nearest, class Again>
Status Engine::State::trace_again(SceneView view, std::size_t count, const Deadline& deadline,
                                  Nearest nearest, Again again) {
  Column<std::size_t> open(count);
  std::iota(open.begin(), open.end(), std::size_t{0});
  for (bool first = true;; first = false) {
    Column<std::uint32_t> next(open.size());
    const auto nodes = unbuilt_nodes(view, open.size());
    const auto look = [&](std::size_t begin, std::size_t end) {
      UnbuiltTrees unbuilt(view, nodes ? &*nodes : nullptr);
      nearest(unbuilt, std::span(&open[begin], end - begin), &next[begin]);
    };
    if (Status status = run(open.size(), deadline, look); !status) return status;
    std::vector<std::uint32_t> wanted;
    std::size_t left = 0;
    for (std::size_t i = 0; i < open.size(); ++i) {
      if (next[i] == kNone) continue;
      if (wanted.empty() || wanted.back() != next[i]) wanted.push_back(next[i]);
      open[left++] = open[i];
    }
    open.resize(left);
    if (open.empty()) return success();
    if (first) view.scene().trees().count_waiting(open.size());
    sort_and_merge(wanted);
    auto tree = view.scene().trees().build(view.shared_tree(), wanted, deadline, threads);
    if (!tree) return std::move(tree).error();
    view = SceneView(view.scene(), std::move(*tree));
    if (Status status = again(view, open); !status) return status;
  }
}

}  // namespace sightline

// Tests: tests/unit/run/engine_test.cpp
