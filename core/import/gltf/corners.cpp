#include "core/import/gltf/corners.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>

#include "core/base/parallel.h"
#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

/// Indices that one thread loads at a time: they are in its cache when their range is taken.
constexpr std::size_t kGrain = 1u << 16;

template <class T>
void widen(const std::byte* from, std::uint64_t count, std::uint32_t* to) {
  for (std::uint64_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, from + i * sizeof(T), sizeof(T));
    to[i] = value;
  }
}

/// Indices begin .. end - 1, packed in the file (the reader checked that they are), without what
/// replaces them.
void load_plain(const AccessorView& view, std::uint64_t begin, std::uint64_t end,
                std::uint32_t* to) {
  const std::uint64_t count = end - begin;
  if (view.base == nullptr) {
    std::fill(to, to + count, 0u);
    return;
  }
  const std::byte* const from = view.base + begin * component_bytes(view.component);
  if (view.component == Component::kU8) {
    widen<std::uint8_t>(from, count, to);
  } else if (view.component == Component::kU16) {
    widen<std::uint16_t>(from, count, to);
  } else {
    std::memcpy(to, from, count * sizeof(std::uint32_t));
  }
}

void replace(const AccessorView& view, std::uint64_t count, std::uint32_t* indices) {
  for (std::uint64_t entry = 0; entry < view.sparse_count; ++entry) {
    const std::uint64_t at = sparse_index(view, entry);
    if (at >= count) break;
    indices[at] = static_cast<std::uint32_t>(
        load_integer(view.sparse_values + entry * component_bytes(view.component), view.component));
  }
}

CornerRange join(const CornerRange& a, const CornerRange& b) {
  return {std::min(a.low, b.low), std::max(a.high, b.high)};
}

/// Four at a time: with one pair of bounds each number would wait for the previous one.
CornerRange range_of(std::span<const std::uint32_t> indices, CornerRange range) {
  using Four = std::uint32_t __attribute__((vector_size(16)));
  Four low = Four{} + range.low, high = Four{} + range.high;
  const std::size_t fours = indices.size() / 4;
  for (std::size_t i = 0; i < fours; ++i) {
    Four next;
    std::memcpy(&next, indices.data() + 4 * i, sizeof next);
    low = next < low ? next : low;
    high = next > high ? next : high;
  }
  for (std::size_t k = 0; k < 4; ++k) range = join(range, {low[k], high[k]});
  for (const std::uint32_t index : indices.subspan(4 * fours)) range = join(range, {index, index});
  return range;
}

/// Calls load(begin, end) for parts of 0 .. count, and finds the range of the indices after that.
template <class Load>
CornerRange range_after(std::uint64_t count, const std::uint32_t* indices, const Load& load) {
  constexpr CornerRange kNothing{std::numeric_limits<std::uint32_t>::max(), 0};
  return parallel_reduce(
      0, count, kGrain, kNothing,
      [&](std::size_t begin, std::size_t end, CornerRange range) {
        load(begin, end);
        return range_of({indices + begin, end - begin}, range);
      },
      join);
}

Status check_range(const std::uint32_t* v, std::uint64_t count, const CornerRange& range,
                   std::uint64_t vertex_count, const std::string& place) {
  if (range.high < vertex_count) return success();
  const auto at = std::find_if(v, v + count, [&](std::uint32_t x) { return x >= vertex_count; });
  return invalid("GLTF_INDEX_OUT_OF_RANGE", place + ": index " + std::to_string(at - v) + " is " +
                                                std::to_string(*at) + ", there are " +
                                                std::to_string(vertex_count) + " vertices");
}

}  // namespace

std::uint64_t triangle_count(int mode, std::uint64_t count) {
  if (mode == TINYGLTF_MODE_TRIANGLES) return count / 3;
  return count >= 3 ? count - 2 : 0;
}

Result<CornerRange> load_corners(const std::optional<AccessorView>& indices,
                                 std::uint64_t vertex_count, int mode, const std::string& place,
                                 std::uint32_t* out) {
  const std::uint64_t listed = indices.has_value() ? indices->count : vertex_count;
  const std::uint64_t triangles = triangle_count(mode, listed);

  // Plain triangles are loaded in place; strips and fans are unrolled from a list of their own.
  UnsetColumn<std::uint32_t> list;
  const bool plain = mode == TINYGLTF_MODE_TRIANGLES;
  const std::uint64_t used = plain ? triangles * 3 : listed;
  if (!plain) list.resize(used);
  std::uint32_t* const v = plain ? out : list.data();
  CornerRange range = range_after(used, v, [&](std::size_t begin, std::size_t end) {
    if (indices.has_value()) {
      load_plain(*indices, begin, end, v + begin);
    } else {
      std::iota(v + begin, v + end, static_cast<std::uint32_t>(begin));
    }
  });
  if (indices.has_value() && indices->sparse_count > 0) {
    replace(*indices, used, v);
    range = range_after(used, v, [](std::size_t, std::size_t) {});
  }
  if (Status status = check_range(v, used, range, vertex_count, place); !status)
    return status.error();
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

SharedColumn<std::uint32_t> stored_corners(const AccessorView& indices, const SharedBytes& shared) {
  if (indices.component != Component::kU32 || indices.sparse_count > 0 || indices.base == nullptr)
    return {};
  return shared.share<std::uint32_t>(indices.base, indices.count / 3 * 3);
}

Result<CornerRange> check_corners(std::span<const std::uint32_t> corners,
                                  std::uint64_t vertex_count, const std::string& place) {
  const CornerRange range =
      range_after(corners.size(), corners.data(), [](std::size_t, std::size_t) {});
  if (Status status = check_range(corners.data(), corners.size(), range, vertex_count, place);
      !status)
    return status.error();
  return range;
}

}  // namespace sightline::gltf
