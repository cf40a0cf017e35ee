#include "core/import/gltf/single_primitive_meshes.h"

#include <span>
#include <utility>

#include "core/base/parallel.h"
#include "core/import/input/mapped_file.h"

namespace sightline::gltf {

namespace {

/// Meshes and triangles that may wait: with many more of them an import would take memory for what
/// waits, and neither tell its progress nor hear that it is cancelled.
constexpr std::size_t kMostWaiting = 1u << 12;
constexpr std::uint64_t kMostWaitingTriangles = 1u << 22;

}  // namespace

Status SinglePrimitiveMeshes::add(std::uint32_t number, Mesh mesh, PrimitiveSource found, int mode,
                                  const Pose& pose) {
  const bool plain =
      found.decoded == nullptr && found.targets.empty() && found.skinning.sets.empty();
  const bool in_order = mode == TINYGLTF_MODE_TRIANGLES;
  Waiting one{number, std::move(mesh), std::move(found), mode, pose};
  const std::uint32_t triangles = one.mesh.primitives[0].triangle_count;
  if (const auto& indices = one.found.indices) {
    one.corner_bytes = accessors_.count(*indices, 0, indices->count, &TouchedBytes::indices);
    if (in_order) one.mesh.indices = stored_corners(*indices, shared_);
  } else if (in_order) {
    one.mesh.indices = IndexColumn::sequence(std::size_t{3} * triangles);
  }
  triangles_ += triangles;
  waiting_.push_back(std::move(one));
  const bool enough = triangles_ >= kMostWaitingTriangles || waiting_.size() >= kMostWaiting;
  return plain && !enough ? success() : load();
}

Status SinglePrimitiveMeshes::load() {
  std::vector<Waiting> batch = std::exchange(waiting_, {});
  triangles_ = 0;
  std::size_t corners = 0, vertices = 0;
  for (Waiting& one : batch) {
    one.first_corner = corners;
    if (one.mesh.indices.empty()) corners += std::size_t{3} * one.mesh.primitives[0].triangle_count;
  }
  // One piece of memory for all of them comes on large pages.
  const auto corner_memory = std::make_shared<UnsetColumn<std::uint32_t>>(corners);
  parallel_for(batch.size(), [&](std::size_t i) { load_corners(batch[i], corner_memory); });
  for (Waiting& one : batch) {
    if (!*one.range) return one.range->error();
    if (Status status = place_vertices(one, vertices); !status) return status;
  }
  const auto vertex_memory = std::make_shared<UnsetColumn<Vec3f>>(vertices);
  parallel_for(batch.size(), [&](std::size_t i) { load_vertices(batch[i], vertex_memory); });
  for (Waiting& one : batch) {
    if (Status status = finish(one); !status) return status;
  }
  return success();
}

void SinglePrimitiveMeshes::load_corners(
    Waiting& one, const std::shared_ptr<UnsetColumn<std::uint32_t>>& memory) {
  will_need(one.corner_bytes);
  const PrimitiveSource& found = one.found;
  IndexColumn& indices = one.mesh.indices;
  const std::size_t count = std::size_t{3} * one.mesh.primitives[0].triangle_count;
  std::uint32_t* unshifted = nullptr;
  if (!indices.listed().empty()) {
    one.range = check_corners(indices.listed(), found.positions.count, found.place);
    if (*one.range && (*one.range)->low > 0) unshifted = indices.own().data();
  } else if (!indices.empty()) {
    one.range = CornerRange{0, static_cast<std::uint32_t>(count - 1)};
  } else {
    unshifted = memory->data() + one.first_corner;
    one.range =
        gltf::load_corners(found.indices, found.positions.count, one.mode, found.place, unshifted);
    indices = SharedColumn<std::uint32_t>(std::span<const std::uint32_t>(unshifted, count), memory);
  }
  if (!*one.range) return;
  const std::uint32_t low = (*one.range)->low;
  for (std::size_t i = 0; i < count && low > 0; ++i) unshifted[i] -= low;
  indices.forget_sequence();
}

/// Finds a place for the vertices in `vertices` elements of memory, unless they stay in the file.
Status SinglePrimitiveMeshes::place_vertices(Waiting& one, std::size_t& vertices) {
  const PrimitiveSource& found = one.found;
  const CornerRange& range = **one.range;
  if (Status status = budget_.spend_bytes(range.count() * sizeof(Vec3f)); !status) return status;
  one.vertex_bytes = count_vertices(found, range, accessors_);
  const AccessorView& view = found.positions;
  const bool plain = view.plain_float() && view.base != nullptr && view.stride == sizeof(Vec3f) &&
                     found.targets.empty() && found.skinning.sets.empty();
  if (plain) {
    one.mesh.positions =
        shared_.share<Vec3f>(view.base + std::size_t{range.low} * sizeof(Vec3f), range.count());
  }
  one.first_vertex = vertices;
  if (one.mesh.positions.empty()) vertices += range.count();
  return success();
}

void SinglePrimitiveMeshes::load_vertices(Waiting& one,
                                          const std::shared_ptr<UnsetColumn<Vec3f>>& memory) {
  will_need(one.vertex_bytes);
  const CornerRange& range = **one.range;
  if (one.mesh.positions.empty()) {
    Vec3f* const out = memory->data() + one.first_vertex;
    one.unbalanced = load_positions(one.found.positions, one.found.targets, one.found.skinning,
                                    range.low, range.count(), one.found.place, out);
    if (!*one.unbalanced) return;
    one.mesh.positions = {std::span<const Vec3f>(out, range.count()), memory};
  }
  one.degenerate_triangles = count_degenerate_triangles(one.mesh);
  one.mesh.all_used = one.degenerate_triangles.all_used;
  one.mesh.nonfinite_triangles = one.degenerate_triangles.nonfinite;
  one.mesh.degenerate_triangles = one.degenerate_triangles.degenerate;
}

Status SinglePrimitiveMeshes::finish(Waiting& one) {
  if (one.unbalanced && !*one.unbalanced) return one.unbalanced->error();
  if (one.unbalanced) warn_of_unbalanced(**one.unbalanced, one.found.place, warnings_);
  attributes_.append(one.found, one.pose, **one.range, (*one.range)->low, one.mesh);
  add_degenerate_triangles(one.degenerate_triangles, one.mesh, scene_.counts, warnings_);
  scene_.meshes[one.number] = std::make_shared<const Mesh>(std::move(one.mesh));
  return success();
}

}  // namespace sightline::gltf
