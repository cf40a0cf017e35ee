#pragma once
/// How an engine traces a batch in one group of trees after the other (tree_groups.h).

#include <bit>
#include <cstdint>
#include <future>
#include <vector>

#include "core/run/engine_state.h"
#include "core/trace/search/tree_groups.h"

namespace sightline {

template <class Limit, class Trace>
Status Engine::State::by_groups(const TreeGroups& groups, const RayBatch& rays,
                                const Deadline& deadline, Limit limit, Trace trace) {
  // Large enough that a kernel gets hundreds of rays at once, which it sorts.
  constexpr std::size_t kGroupSlice = 8 * kSlice;
  Column<std::uint64_t> met(rays.size());
  Status status = run(rays.size(), deadline, [&](std::size_t begin, std::size_t end) {
    groups.find(rays, begin, end, met.data());
  });
  std::vector<std::size_t> counts(groups.size());
  for (const std::uint64_t bits : met) {
    for (std::uint64_t left = bits; left != 0; left &= left - 1) {
      ++counts[static_cast<std::size_t>(std::countr_zero(left))];
    }
  }
  // Begins where another batch reads now, so that both need the same pages.
  const std::size_t first = group_read.load(std::memory_order_relaxed) % groups.size();
  const auto group_at = [&](std::size_t step) { return (first + step) % groups.size(); };
  const auto after = [&](std::size_t step) {
    while (step < groups.size() && counts[group_at(step)] == 0) ++step;
    return step;
  };
  for (std::size_t step = after(0), next = step; status && step < groups.size(); step = next) {
    const std::size_t group = group_at(step);
    group_read.store(group, std::memory_order_relaxed);
    next = after(step + 1);
    const SceneView view = groups.view(group);
    // It waits for the disk, so it is none of the threads that trace. Without a thread it runs later.
    const auto reading = std::async([&] {
      if (next < groups.size()) groups.prepare(group_at(next), counts[group_at(next)]);
    });
    const auto slice = [&](std::size_t begin, std::size_t end) {
      std::vector<std::size_t> numbers(end - begin);
      std::size_t count = 0;
      for (std::size_t i = begin; i < end; ++i) {
        numbers[count] = i;
        count += met[i] >> group & 1u;
      }
      RayBatch some;
      some.reserve(count);
      numbers.resize(count);
      std::erase_if(numbers, [&](std::size_t i) {
        Ray ray = rays[i];
        ray.tmax = limit(i);
        if (!(ray.tmax >= ray.tmin)) return true;
        some.push_back(ray);
        if (!rays.mask.empty()) some.mask.push_back(rays.mask[i]);
        return false;
      });
      if (!numbers.empty()) trace(view, some, numbers);
    };
    status = run(rays.size(), deadline, slice, kGroupSlice);
    reading.wait();
    groups.release(group);
  }
  return status;
}

}  // namespace sightline

// Tests: tests/unit/run/tree_groups_test.cpp
