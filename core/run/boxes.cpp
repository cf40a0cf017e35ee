/// Batches of boxes on the threads of the engine.

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <type_traits>
#include <vector>

#include "core/run/engine_state.h"
#include "core/run/unbuilt_rounds.h"
#include "core/scene/scene.h"
#include "core/trace/search/box_contact.h"
#include "core/trace/search/box_overlap.h"
#include "core/trace/search/box_region.h"

namespace sightline {

namespace {

/// Boxes that one thread takes at a time. A box may touch the whole scene, so it reads the clock
/// itself.
constexpr std::size_t kBoxSlice = 8;

/// Contacts that one thread computes at a time; of a large hull one may take a millisecond.
constexpr std::size_t kContactSlice = 16;

/// Which trees each box comes near.
auto near_boxes(const BoxBatch& boxes) {
  return [&](UnbuiltTrees& unbuilt, std::size_t i, std::vector<std::uint32_t>& trees) {
    unbuilt.touched(boxes, i, trees);
  };
}

/// The part of the scene's bounds that a shape takes on one axis, from 0 to 1.
double part_of_side(double scene_min, double scene_max, double min, double max) {
  const double low = std::max(scene_min, min), high = std::min(scene_max, max);
  // Halves, because the difference of finite numbers may overflow. A flat scene has no side here.
  const double side = scene_max / 2 - scene_min / 2;
  return side > 0 ? std::min(1.0, (high / 2 - low / 2) / side) : 1;
}

/// Triangles lie on surfaces, so a part of the space holds more of them than its volume says: the
/// third side does not count.
double part_of_triangles(const Box3d& scene, const Box3d& shape) {
  std::array<double, 3> parts{};
  for (int k = 0; k < 3; ++k) {
    if (!(shape.min[k] <= scene.max[k] && shape.max[k] >= scene.min[k])) return 0;
    parts[static_cast<std::size_t>(k)] =
        part_of_side(scene.min[k], scene.max[k], shape.min[k], shape.max[k]);
  }
  std::sort(parts.begin(), parts.end());
  return parts[1] * parts[2];
}

}  // namespace

std::uint64_t Engine::expected_triangles(const Scene& scene, const BoxBatch& boxes) {
  const Box3d& bounds = scene.bounds();
  const auto part = [&bounds](const auto& shape) -> double {
    using Shape = std::decay_t<decltype(shape)>;
    if constexpr (std::is_same_v<Shape, ConvexRegion>) {
      return 1;
    } else if constexpr (std::is_same_v<Shape, Box3d>) {
      return part_of_triangles(bounds, shape);
    } else {
      return part_of_triangles(bounds, outer_bounds(shape));
    }
  };
  // One triangle far away makes the bounds say nothing of where the others are.
  constexpr double kLeastPart = 0.125, kLeastTriangles = 1 << 19;
  const auto all = static_cast<double>(scene.instanced_triangle_count());
  const double least = std::min(kLeastPart * all, kLeastTriangles);
  double triangles = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const double of_box = boxes.visit(i, part);
    if (of_box > 0) triangles += std::max(of_box * all, least);
  }
  constexpr double kMost = 0x1p62;
  return static_cast<std::uint64_t>(std::min(triangles, kMost));
}

Status Engine::ray_boxes(const RayBatch& rays, const BoxBatch& boxes, BoxPairing pairing,
                         RayBoxDetail detail, const Deadline& deadline,
                         RayBoxAnswers& answers) const {
  return within_memory([&]() -> Status {
    const std::size_t count =
        pairing == BoxPairing::kEach ? rays.size() : rays.size() * boxes.size();
    answers.resize(count, detail);
    return state_->run(count, deadline, [&](std::size_t begin, std::size_t end) {
      state_->kernel.ray_boxes(rays, boxes, pairing, begin, end, answers);
    });
  });
}

Status Engine::boxes_any(const Scene& scene, const BoxBatch& boxes, const Deadline& deadline,
                         Column<std::uint8_t>& touched, BoxRelation relation) const {
  const SceneTrees::Use use(scene.trees());
  return within_memory([&]() -> Status {
    touched.assign(boxes.size(), 0);
    const auto view = state_->with_trees(scene, boxes.size(), deadline, near_boxes(boxes));
    if (!view) return view.error();
    std::atomic<bool> stopped{false};
    const auto part = [&](std::size_t begin, std::size_t end) {
      BoxOverlaps overlaps(*view, deadline);
      for (std::size_t i = begin; i < end; ++i)
        touched[i] = overlaps.any(boxes, i, relation) ? 1 : 0;
      if (overlaps.stopped()) stopped.store(true);
    };
    Status status = state_->run(boxes.size(), deadline, part, kBoxSlice);
    if (status && stopped.load()) return out_of_time(deadline);
    return status;
  });
}

Status Engine::boxes_count(const Scene& scene, const BoxBatch& boxes, const BoxQuestion& question,
                           const Deadline& deadline, Column<std::uint64_t>& totals) const {
  return within_memory([&]() -> Status {
    BoxLists lists;
    return boxes_list(scene, boxes, question, {}, deadline, lists, totals);
  });
}

Status Engine::boxes_list(const Scene& scene, const BoxBatch& boxes, const BoxQuestion& question,
                          const ListLimits& limits, const Deadline& deadline, BoxLists& lists,
                          Column<std::uint64_t>& totals) const {
  const SceneTrees::Use use(scene.trees());
  return within_memory([&]() -> Status {
    // Every slice fills a list of its own; they are joined in the order of boxes.
    std::vector<BoxLists> slices((boxes.size() + kBoxSlice - 1) / kBoxSlice);
    std::atomic<std::size_t> gathered{0};
    std::atomic<bool> stopped{false};
    totals.assign(boxes.size(), 0);
    lists.next.assign(boxes.size(), 0);
    Column<std::size_t> listed(boxes.size());
    // One more than may be answered is enough to know that it is too many.
    const std::size_t resolved = limits.each > limits.total ? limits.total + 1 : limits.each;
    const auto view = state_->with_trees(scene, boxes.size(), deadline, near_boxes(boxes));
    if (!view) return view.error();
    const auto part = [&](std::size_t begin, std::size_t end) {
      BoxOverlaps overlaps(*view, deadline);
      BoxLists& slice = slices[begin / kBoxSlice];
      for (std::size_t i = begin; i < end; ++i) {
        if (gathered.load(std::memory_order_relaxed) > limits.total) return;
        totals[i] = overlaps.list(boxes, i, question.targets, resolved, question.relation,
                                  question.from_of(i));
        lists.next[i] = overlaps.next();
        listed[i] = overlaps.triangles().size() + overlaps.nodes().size();
        if (overlaps.stopped()) {
          stopped.store(true);
          return;
        }
        slice.triangles.insert(slice.triangles.end(), overlaps.triangles().begin(),
                               overlaps.triangles().end());
        slice.nodes.insert(slice.nodes.end(), overlaps.nodes().begin(), overlaps.nodes().end());
        gathered.fetch_add(listed[i], std::memory_order_relaxed);
      }
    };
    Status status = state_->run(boxes.size(), deadline, part, kBoxSlice);
    if (!status) return status;
    if (stopped.load()) return out_of_time(deadline);
    if (gathered.load() > limits.total) {
      return Error{ErrorKind::kTooLarge, "TOO_MANY_HITS",
                   "the boxes touch more than " + std::to_string(limits.total) +
                       " things; send fewer boxes or a smaller limit",
                   ""};
    }

    lists.first.assign(1, 0);
    lists.first.reserve(boxes.size() + 1);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      lists.first.push_back(lists.first.back() + listed[i]);
    }
    lists.triangles.clear();
    lists.nodes.clear();
    for (const BoxLists& slice : slices) {
      lists.triangles.insert(lists.triangles.end(), slice.triangles.begin(), slice.triangles.end());
      lists.nodes.insert(lists.nodes.end(), slice.nodes.begin(), slice.nodes.end());
    }
    return success();
  });
}

Status Engine::boxes_contacts(const Scene& scene, const BoxBatch& boxes, const BoxLists& lists,
                              const Deadline& deadline, BoxContacts& contacts) const {
  return within_memory([&]() -> Status {
    const std::size_t count = lists.triangles.size();
    contacts.depth.assign(count, 0);
    contacts.normal.assign(count, {});
    std::atomic<bool> stopped{false};
    const auto part = [&](std::size_t begin, std::size_t end) {
      std::optional<BoxContactSearch> of_box;
      std::size_t box = 0;
      for (std::size_t i = begin; i < end && !stopped.load(std::memory_order_relaxed); ++i) {
        if (!of_box || i >= lists.first[box + 1]) {
          const auto after = std::upper_bound(lists.first.begin(), lists.first.end(), i);
          box = static_cast<std::size_t>(after - lists.first.begin()) - 1;
          of_box.emplace(boxes, box, deadline);
        }
        const auto contact = of_box->with(scene.world_triangle(lists.triangles[i]));
        if (!contact) {
          stopped.store(true);
          return;
        }
        contacts.depth[i] = contact->depth;
        contacts.normal[i] = contact->normal;
      }
    };
    Status status = state_->run(count, deadline, part, kContactSlice);
    if (status && stopped.load()) return out_of_time(deadline);
    return status;
  });
}

}  // namespace sightline
