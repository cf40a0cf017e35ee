#pragma once
/// How an engine traces a batch in one group of trees after the other (tree_groups.h).

#include <algorithm>
#include <bit>
#include <cstdint>
#include <future>
#include <system_error>
#include <vector>

#include "core/run/engine_state.h"
#include "core/trace/search/tree_groups.h"

namespace sightline {

template <class Limit, class Trace>
Status Engine::State::by_groups(TreeGroups& groups, const RayBatch& rays, const Deadline& deadline,
                                Limit limit, Trace trace) {
  // The rays of a group are divided into about so many slices. A kernel sorts the rays of a slice.
  constexpr std::size_t kSlices = 8, kLeastSlice = kSlice / 4, kMostSlice = 8 * kSlice;
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
  // Begins where a batch has read last: another one that runs needs the pages from there on.
  const std::size_t first = group_read.load(std::memory_order_relaxed) % groups.size();
  const auto group_at = [&](std::size_t step) { return (first + step) % groups.size(); };
  const auto after = [&](std::size_t step) {
    while (step < groups.size() && counts[group_at(step)] == 0) ++step;
    return step;
  };
  std::vector<std::size_t> numbers(rays.size());  // of the rays that may meet the group
  for (std::size_t step = after(0), next = step; status && step < groups.size(); step = next) {
    const std::size_t group = group_at(step);
    group_read.store(group, std::memory_order_relaxed);
    next = after(step + 1);
    const SceneView view = groups.show(group);
    // It waits for the disk, so it is none of the threads that trace. Where there is no thread, the
    // traversal reads.
    std::future<void> reading;
    if (next < groups.size() && groups.is_worth_reading(group_at(next), counts[group_at(next)])) {
      try {
        reading = std::async(std::launch::async, [&] { groups.read(group_at(next)); });
      } catch (const std::system_error&) {
      }
    }
    std::size_t count = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      numbers[count] = i;
      count += met[i] >> group & 1u;
    }
    const auto slice = [&](std::size_t begin, std::size_t end) {
      std::vector<std::size_t> wanted;
      wanted.reserve(end - begin);
      RayBatch some;
      some.resize(end - begin);
      if (!rays.mask.empty()) some.mask.resize(end - begin);
      for (std::size_t k = begin; k < end; ++k) {
        const std::size_t i = numbers[k];
        Ray ray = rays[i];
        ray.tmax = limit(i);
        if (!(ray.tmax >= ray.tmin)) continue;
        some.set(wanted.size(), ray);
        if (!rays.mask.empty()) some.mask[wanted.size()] = rays.mask[i];
        wanted.push_back(i);
      }
      some.resize(wanted.size());
      if (!rays.mask.empty()) some.mask.resize(wanted.size());
      if (!wanted.empty()) trace(view, some, wanted);
    };
    status = run(count, deadline, slice, std::clamp(count / kSlices, kLeastSlice, kMostSlice));
    if (reading.valid()) reading.wait();
    groups.release(group);
  }
  return status;
}

}  // namespace sightline

// Tests: tests/unit/run/tree_groups_test.cpp
