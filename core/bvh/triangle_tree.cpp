#include "core/bvh/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/parallel.h"
#include "core/bvh/block_vertices.h"
#include "core/bvh/collapse.h"
#include "core/bvh/reinsert.h"
#include "core/bvh/tree_corners.h"
#include "core/geometry/rounding.h"

namespace sightline {

namespace {

constexpr std::uint32_t kMaxLeafBoxes = 8;

/// The triangles `numbers`, at most kLanes; lanes without one repeat the first.
std::array<std::uint32_t, kLanes> triangles_of(const PartNumbers& numbering,
                                               std::span<const std::uint32_t> numbers) {
  std::array<std::uint32_t, kLanes> triangles;
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    triangles[lane] = numbering.place_of(numbers[lane < numbers.size() ? lane : 0]).triangle;
  return triangles;
}

/// The triangles `numbers` of one part, at most kLanes.
void write_block(std::span<const TreePart> parts, const PartNumbers& numbering,
                 std::span<const std::uint32_t> numbers, LeafBlock& block) {
  const PartNumbers::Place first = numbering.place_of(numbers[0]);
  const MeshView& mesh = parts[first.part].mesh;
  const auto triangles = triangles_of(numbering, numbers);
  const BlockVertices vertices(mesh.indices, triangles);
  block.set_capacity(vertices.capacity());
  float at[LeafBlock::kMostVertices][3];                       // by place
  std::array<std::uint32_t, LeafBlock::kMostVertices> number;  // of the vertex of a place
  std::uint64_t numbers_of_corners = 0;
  std::uint32_t count = 0;
  for (std::size_t place = 0; place < LeafBlock::kMostVertices; ++place) {
    const std::uint32_t first_place = vertices.first(place);
    if (first_place == place || !block.has_numbers()) {
      const Vec3f& p = mesh.positions[vertices.index(place)];
      for (int axis = 0; axis < 3; ++axis)
        at[place][axis] = block.vertices(static_cast<std::size_t>(axis))[count] = p[axis];
      number[place] = count++;
    } else {
      number[place] = number[first_place];
    }
    numbers_of_corners |= std::uint64_t{number[place] & 7u} << 3 * place;
  }
  if (block.has_numbers()) block.set_vertex_numbers(numbers_of_corners);
  float edge_max = 0;
  for (std::size_t lane = 0; lane < numbers.size(); ++lane) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float* p = at[vertices.first(c * kLanes + lane)];
      const float* q = at[vertices.first((c == 2 ? 0 : c + 1) * kLanes + lane)];
      for (std::size_t axis = 0; axis < 3; ++axis)
        edge_max = std::max(edge_max, std::abs(q[axis] - p[axis]));
    }
  }
  block.set_names(triangles, static_cast<std::uint32_t>(numbers.size()), first.part);
  // A difference of two float32 is off by at most half an ulp.
  block.set_edge_max(std::nextafter(edge_max, kInfF));
}

/// The boxes of the parts' usable triangles, in tree units. Two triangles that follow each other in
/// a mesh share a box if it is hardly larger than theirs, as for the halves of a quadrilateral. The
/// builder then has up to half as many boxes (docs/decisions/0034).
struct BuildBoxes {
  Column<BuildBox> boxes;
  Box3d bounds;  ///< of the triangles, before units
  int scale_exponent = 0;

  BuildBoxes(std::span<const TreePart> parts, const PartNumbers& numbering)
      : boxes(numbering.count()), parts_(parts), numbering_(numbering) {
    make();
    scale_exponent = bounds.empty() ? 0 : choose_scale_exponent(bounds);
    // Rare: the bounds turn out to ask for other units.
    if (scale_exponent != 0) make();
  }

 private:
  static constexpr std::uint32_t kChunk = 4096;
  /// The largest surface area of a shared box, as a part of the sum of both. Below 1, testing
  /// both in one block costs a ray less than testing them apart.
  static constexpr float kShared = 0.7f;
  static constexpr float kNever = -std::numeric_limits<float>::infinity();

  /// Each chunk packs its own boxes; chunks are moved up to each other only if one of them has
  /// gaps.
  void make() {
    const std::uint32_t count = numbering_.count();
    boxes.resize(count);
    const std::uint32_t chunks = (count + kChunk - 1) / kChunk;
    std::vector<std::uint32_t> used(chunks);
    std::vector<Box3d> within(chunks);
    parallel_for(chunks, [&](std::size_t chunk) {
      const auto first = static_cast<std::uint32_t>(chunk) * kChunk;
      used[chunk] = make_chunk(first, std::min(count, first + kChunk), within[chunk]);
    });
    bounds = {};
    BuildBox* end = boxes.data();
    for (std::uint32_t chunk = 0; chunk < chunks; ++chunk) {
      bounds.include(within[chunk]);
      const BuildBox* from = boxes.data() + std::size_t{chunk} * kChunk;
      end = end == from ? end + used[chunk] : std::copy(from, from + used[chunk], end);
    }
    boxes.resize(static_cast<std::size_t>(end - boxes.data()));
  }

  /// Makes the boxes of the numbers [first, end), from boxes[first] on. Returns how many.
  std::uint32_t make_chunk(std::uint32_t first, std::uint32_t end, Box3d& within) {
    BuildBox* to = &boxes[first];
    Bounds last;               // the box before this one
    float last_area = kNever;  // half its surface area if it may be shared
    Bounds own;                // of the triangles that need no conversion
    PartNumbers::Place place;
    std::uint32_t known = first;  // the end of the numbers that follow `place`
    for (std::uint32_t i = first; i < end; ++i, ++place.triangle) {
      if (i == known) {
        place = numbering_.place_of(i);
        known = i + numbering_.stretch(i);
        last_area = kNever;
      }
      const TreePart& part = parts_[place.part];
      Bounds box;
      if (part.world_from_mesh == nullptr && scale_exponent == 0) {
        if (!bound_own(part.mesh, place.triangle, box)) {
          last_area = kNever;
          continue;
        }
        own.include_numbers(box);
      } else if (!bound_converted(part, place.triangle, box, within)) {
        last_area = kNever;
        continue;
      }
      Bounds shared = last;
      shared.include(box);
      const float area = box.half_area();
      if (shared.half_area() <= kShared * (last_area + area)) {
        --to;
        store(shared, i - 1, 2, *to++);
        last_area = kNever;
      } else {
        store(box, i, 1, *to++);
        last = box;
        last_area = area;
      }
    }
    if (own.lower.first() <= own.upper.first()) {
      alignas(16) float at[2][4];
      own.lower.store(at[0]);
      own.upper.store(at[1]);
      for (const auto& p : at)
        within.include(
            Vec3d{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
    }
    return static_cast<std::uint32_t>(to - &boxes[first]);
  }

  static void store(const Bounds& bounds, std::uint32_t id, std::uint32_t count, BuildBox& box) {
    bounds.lower.store(box.lower);
    bounds.upper.store(box.upper);
    box.id = id;
    box.count = count;
  }

  /// The box of a triangle in the mesh's own space and units. False if the tree does not need the
  /// triangle (TreeCorners::usable).
  static bool bound_own(const MeshView& mesh, std::uint32_t triangle, Bounds& box) {
    const auto index = mesh.indices.corners(triangle);
    const Vec3f& a = mesh.positions[index[0]];
    const Vec3f& b = mesh.positions[index[1]];
    const Vec3f& c = mesh.positions[index[2]];
    if (a == b || b == c || c == a) return false;
    if (!is_finite(a) || !is_finite(b) || !is_finite(c)) return false;
    for (const Vec3f* p : {&a, &b, &c}) box.include_numbers(Float4::of(p->x, p->y, p->z));
    return true;
  }
  /// The box of a triangle in tree units, rounded outwards. Extends `within` by the corners in the
  /// space of the tree, before units. False as above.
  bool bound_converted(const TreePart& part, std::uint32_t triangle, Bounds& box,
                       Box3d& within) const {
    const TreeCorners corners = tree_corners(part.mesh, triangle, part.world_from_mesh);
    if (!corners.usable) return false;
    for (const Vec3d& p : corners.at) within.include(p);
    const double scale = std::ldexp(1.0, scale_exponent);
    for (const Vec3d& p : corners.at) {
      const Vec3d scaled{p.x * scale, p.y * scale, p.z * scale};
      box.lower =
          min(Float4::of(float_below(scaled.x), float_below(scaled.y), float_below(scaled.z)),
              box.lower);
      box.upper =
          max(Float4::of(float_above(scaled.x), float_above(scaled.y), float_above(scaled.z)),
              box.upper);
    }
    return true;
  }

  std::span<const TreePart> parts_;
  const PartNumbers& numbering_;
};

/// The boxes of a leaf, part by part. `apart`: not all boxes may share a block.
class LeafParts {
 public:
  LeafParts(const PartNumbers& numbering, bool apart, const std::uint32_t* numbers,
            std::uint32_t count)
      : numbering_(numbering), apart_(apart), count_(count) {
    std::copy_n(numbers, count, numbers_.begin());
    if (apart) std::sort(numbers_.begin(), numbers_.begin() + count);
  }

  /// Calls `block` with the numbers of each block.
  template <class Block>
  void blocks(Block block) const {
    for (std::uint32_t first = 0; first < count_;) {
      std::uint32_t end = std::min<std::uint32_t>(count_, first + kLanes);
      while (apart_ && !may_share(numbers_[first], numbers_[end - 1])) --end;
      block(std::span<const std::uint32_t>(&numbers_[first], end - first));
      first = end;
    }
  }

 private:
  bool may_share(std::uint32_t least, std::uint32_t greatest) const {
    const PartNumbers::Place first = numbering_.place_of(least);
    const PartNumbers::Place last = numbering_.place_of(greatest);
    return first.part == last.part && LeafBlock::fit(first.triangle, last.triangle, first.part);
  }

  const PartNumbers& numbering_;
  bool apart_;
  std::uint32_t count_;
  std::array<std::uint32_t, kMaxLeafBoxes> numbers_{};
};

}  // namespace

int choose_scale_exponent(const Box3d& bounds) {
  double largest = 0;
  for (int k = 0; k < 3; ++k) {
    largest = std::max({largest, std::abs(bounds.min[k]), std::abs(bounds.max[k])});
  }
  if (!(largest > 0)) return 0;
  // Capped so that the power itself is a finite float64.
  const int exponent = std::clamp(std::ilogb(largest), -1000, 1022);
  return exponent > 40 || exponent < -40 ? -exponent : 0;
}

PartNumbers::PartNumbers(std::span<const TreePart> parts) : runs_(parts.front().runs) {
  std::uint32_t end = 0;
  for (const TriangleRun& run : runs_) run_ends_.push_back(end += run.count);
  if (!runs_.empty()) {
    ends_.push_back(end);
    return;
  }
  for (const TreePart& part : parts) ends_.push_back(end += part.mesh.triangle_count());
}

std::uint32_t PartNumbers::part_of(std::uint32_t number) const {
  return static_cast<std::uint32_t>(std::upper_bound(ends_.begin(), ends_.end() - 1, number) -
                                    ends_.begin());
}

PartNumbers::Place PartNumbers::place_of(std::uint32_t number) const {
  if (!runs_.empty()) {
    const auto run = static_cast<std::size_t>(
        std::upper_bound(run_ends_.begin(), run_ends_.end(), number) - run_ends_.begin());
    // Numbers count from the end of the run back, so that the first run is no special case.
    return {0, runs_[run].first + runs_[run].count - (run_ends_[run] - number)};
  }
  const std::uint32_t part = part_of(number);
  return {part, number - begin(part)};
}

std::uint32_t PartNumbers::stretch(std::uint32_t number) const {
  const std::vector<std::uint32_t>& ends = runs_.empty() ? ends_ : run_ends_;
  return *std::upper_bound(ends.begin(), ends.end() - 1, number) - number;
}

bool PartNumbers::spans_far() const {
  if (runs_.empty()) return ends_.front() > LeafBlock::kNear;
  return runs_.back().first + runs_.back().count - runs_.front().first > LeafBlock::kNear;
}

std::optional<std::uint32_t> PartNumbers::number(Place place) const {
  if (runs_.empty()) return begin(place.part) + place.triangle;
  const auto after = std::upper_bound(
      runs_.begin(), runs_.end(), place.triangle,
      [](std::uint32_t triangle, const TriangleRun& run) { return triangle < run.first; });
  if (after == runs_.begin()) return std::nullopt;
  const auto run = static_cast<std::size_t>(after - runs_.begin()) - 1;
  const std::uint32_t within = place.triangle - runs_[run].first;
  if (within >= runs_[run].count) return std::nullopt;
  return run_ends_[run] - (runs_[run].count - within);
}

WideTree build_triangle_tree(const MeshView& mesh, const Affine* world_from_mesh,
                             TreeQuality quality, const CancelFlag* cancel) {
  const TreePart part{mesh, world_from_mesh};
  return build_triangle_tree({&part, 1}, quality, cancel);
}

WideTree build_triangle_tree(std::span<const TreePart> parts, TreeQuality quality,
                             const CancelFlag* cancel) {
  const PartNumbers numbering(parts);
  const bool several = parts.size() > 1;
  if (is_cancelled(cancel)) return {};
  BuildBoxes made(parts, numbering);
  const Box3d bounds = made.bounds;
  const int scale_exponent = made.scale_exponent;
  BinaryTree binary = build_binary_tree(std::move(made.boxes), {.cancel = cancel});
  if (quality == TreeQuality::kHigh) reinsert(binary, {.cancel = cancel});
  CollapseOptions options;
  options.cancel = cancel;
  options.leaf_max = std::min(options.leaf_max, kMaxLeafBoxes);
  const bool apart = several || numbering.spans_far();
  const auto leaf_parts = [&](std::uint32_t first, std::uint32_t count) {
    return LeafParts(numbering, apart, &binary.ids[first], count);
  };
  // Of such trees a scene has few, and a small one stays in the first cache: only time counts.
  constexpr std::size_t kFewBoxes = 64;
  if (several && binary.ids.size() <= kFewBoxes) options.memory_cost = 0;
  LeafContent content;
  content.size = [&](std::uint32_t first, std::uint32_t count) {
    LeafSize size;
    leaf_parts(first, count).blocks([&](std::span<const std::uint32_t> numbers) {
      const IndexView& indices = parts[numbering.place_of(numbers[0]).part].mesh.indices;
      const BlockVertices vertices(indices, triangles_of(numbering, numbers));
      ++size.blocks;
      size.granules += LeafBlock::granules_for(vertices.capacity());
    });
    return size;
  };
  content.write = [&](std::uint32_t first, std::uint32_t count, LeafBlock* block) {
    leaf_parts(first, count).blocks([&](std::span<const std::uint32_t> numbers) {
      write_block(parts, numbering, numbers, *block);
      block = block->next();
    });
    return block;
  };
  WideTree tree = collapse(binary, options, content);
  tree.scale_exponent = scale_exponent;
  tree.bounds = bounds;
  return tree;
}

}  // namespace sightline
