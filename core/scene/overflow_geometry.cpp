#include "core/scene/overflow_geometry.h"

#include <algorithm>
#include <memory>
#include <span>

#include "core/base/shared_column.h"

namespace sightline {
namespace {

/// `elements` in overflow memory; empty if it has no room.
template <class T>
SharedColumn<T> moved(std::span<const T> elements, OverflowMemory& overflow) {
  const auto memory = overflow.take(elements.size_bytes());
  if (!memory) return {};
  T* const begin = reinterpret_cast<T*>(memory.get());
  std::copy(elements.begin(), elements.end(), begin);
  return {std::span<const T>(begin, elements.size()), memory};
}

template <class T>
bool is_elsewhere(std::span<const T> elements, const OverflowMemory& overflow) {
  return !elements.empty() && !overflow.contains(elements.data());
}

}  // namespace

Status move_geometry(SceneDescription& scene) {
  OverflowMemory& overflow = *scene.overflow;
  for (auto& mesh : scene.meshes) {
    const std::span<const Vec3f> positions = mesh->positions;
    const std::span<const std::uint32_t> indices = mesh->indices.listed();
    SharedColumn<Vec3f> new_positions;
    SharedColumn<std::uint32_t> new_indices;
    const bool moves_positions = is_elsewhere(positions, overflow);
    const bool moves_indices = is_elsewhere(indices, overflow);
    if (moves_positions) new_positions = moved(positions, overflow);
    if (moves_indices) new_indices = moved(indices, overflow);
    if (new_positions.empty() == moves_positions || new_indices.empty() == moves_indices) {
      return Error{
          ErrorKind::kOutOfSpace, "OVERFLOW_FULL",
          "the scene's geometry exceeds the memory budget, and the temporary files for the "
          "rest have no room for it",
          ""};
    }
    if (!moves_positions && !moves_indices) continue;
    auto next = std::make_shared<Mesh>(*mesh);
    if (moves_positions) next->positions = std::move(new_positions);
    if (moves_indices) next->indices = std::move(new_indices);
    mesh = std::move(next);
  }
  return success();
}

}  // namespace sightline
