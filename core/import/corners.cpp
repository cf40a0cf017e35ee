#include "core/import/corners.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "core/import/refusal.h"

namespace sightline::gltf {

namespace {

template <class T>
void widen(const std::byte* from, std::uint64_t count, std::uint32_t* to) {
  for (std::uint64_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, from + i * sizeof(T), sizeof(T));
    to[i] = value;
  }
}

/// `count` indices, packed in the file (the reader checked that they are).
void load_indices(const AccessorView& view, std::uint64_t count, std::uint32_t* to) {
  if (view.base == nullptr) {
    std::fill(to, to + count, 0u);
  } else if (view.component == Component::kU8) {
    widen<std::uint8_t>(view.base, count, to);
  } else if (view.component == Component::kU16) {
    widen<std::uint16_t>(view.base, count, to);
  } else {
    std::memcpy(to, view.base, count * sizeof(std::uint32_t));
  }
  for (std::uint64_t entry = 0; entry < view.sparse_count; ++entry) {
    const std::uint64_t at = sparse_index(view, entry);
    if (at >= count) break;
    to[at] = static_cast<std::uint32_t>(
        load_integer(view.sparse_values + entry * component_bytes(view.component), view.component));
  }
}

}  // namespace

std::uint64_t triangle_count(int mode, std::uint64_t count) {
  if (mode == TINYGLTF_MODE_TRIANGLES) return count / 3;
  return count >= 3 ? count - 2 : 0;
}

Result<CornerRange> append_corners(const std::optional<AccessorView>& indices,
                                   std::uint64_t vertex_count, int mode, const std::string& place,
                                   Column<std::uint32_t>& corners) {
  const std::uint64_t listed = indices.has_value() ? indices->count : vertex_count;
  const std::uint64_t triangles = triangle_count(mode, listed);
  const std::size_t first = corners.size();
  corners.resize(first + triangles * 3);
  std::uint32_t* const out = corners.data() + first;

  // Plain triangles are loaded in place; strips and fans are unrolled from a list of their own.
  Column<std::uint32_t> list;
  const bool plain = mode == TINYGLTF_MODE_TRIANGLES;
  const std::uint64_t used = plain ? triangles * 3 : listed;
  if (!plain) list.resize(used);
  std::uint32_t* const v = plain ? out : list.data();
  if (indices.has_value()) {
    load_indices(*indices, used, v);
  } else {
    std::iota(v, v + used, 0u);
  }
  CornerRange range = {v[0], v[0]};
  for (std::uint64_t i = 0; i < used; ++i) {
    range.low = std::min(range.low, v[i]);
    range.high = std::max(range.high, v[i]);
  }
  if (range.high >= vertex_count) {
    const auto at = std::find_if(v, v + used, [&](std::uint32_t x) { return x >= vertex_count; });
    return invalid("GLTF_INDEX_OUT_OF_RANGE", place + ": index " + std::to_string(at - v) + " is " +
                                                  std::to_string(*at) + ", there are " +
                                                  std::to_string(vertex_count) + " vertices");
  }
  if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    for (std::uint64_t i = 0; i < triangles; ++i) {
      out[i * 3] = v[i];
      out[i * 3 + 1] = v[i + 1 + i % 2];
      out[i * 3 + 2] = v[i + 2 - i % 2];
    }
  } else if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
    for (std::uint64_t i = 0; i < triangles; ++i) {
      out[i * 3] = v[i + 1];
      out[i * 3 + 1] = v[i + 2];
      out[i * 3 + 2] = v[0];
    }
  }
  return range;
}

}  // namespace sightline::gltf
