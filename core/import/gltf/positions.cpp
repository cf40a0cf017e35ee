#include "core/import/gltf/positions.h"

#include <algorithm>
#include <cstring>

#include "core/base/parallel.h"

namespace sightline::gltf {

namespace {

constexpr std::uint64_t kBlock = 512;        ///< elements that are decoded at a time, on the stack
constexpr std::uint64_t kCopied = 1u << 16;  ///< that one thread copies at a time

/// Elements first .. first + count - 1 in float64, replacements included.
void load_block(const AccessorView& view, std::uint64_t first, std::uint64_t count, Vec3d* out) {
  const std::size_t size = component_bytes(view.component);
  const auto decode = [&](const std::byte* at) {
    return Vec3d{load_number(at, view.component, view.normalized),
                 load_number(at + size, view.component, view.normalized),
                 load_number(at + 2 * size, view.component, view.normalized)};
  };
  for (std::uint64_t i = 0; i < count; ++i) {
    out[i] = view.base != nullptr ? decode(view.base + (first + i) * view.stride) : Vec3d{};
  }
  for (std::uint64_t entry = sparse_lower_bound(view, first); entry < view.sparse_count; ++entry) {
    const std::uint64_t at = sparse_index(view, entry);
    if (at >= first + count) break;
    out[at - first] = decode(view.sparse_values + entry * view.element_bytes());
  }
}

void copy_floats(const AccessorView& view, std::uint64_t first, std::uint64_t count, Vec3f* out) {
  static_assert(sizeof(Vec3f) == 12);
  if (view.base == nullptr) {
    std::fill(out, out + count, Vec3f{});
  } else if (view.stride == sizeof(Vec3f)) {
    const std::byte* const from = view.base + first * view.stride;
    parallel_for((count + kCopied - 1) / kCopied, [&](std::size_t piece) {
      const std::uint64_t begin = piece * kCopied, n = std::min(kCopied, count - begin);
      std::memcpy(out + begin, from + begin * sizeof(Vec3f), n * sizeof(Vec3f));
    });
  } else {
    for (std::uint64_t i = 0; i < count; ++i) {
      std::memcpy(out + i, view.base + (first + i) * view.stride, sizeof(Vec3f));
    }
  }
}

}  // namespace

Result<std::uint64_t> load_positions(const AccessorView& base,
                                     const std::vector<WeightedTarget>& targets,
                                     const Skinning& skinning, std::uint64_t first,
                                     std::uint64_t count, const std::string& place, Vec3f* out) {
  if (base.plain_float() && targets.empty() && skinning.sets.empty()) {
    copy_floats(base, first, count, out);
    return std::uint64_t{0};
  }
  std::uint64_t unbalanced = 0;
  Vec3d p[kBlock], d[kBlock];
  for (std::uint64_t done = 0; done < count; done += kBlock) {
    const std::uint64_t n = std::min(kBlock, count - done);
    load_block(base, first + done, n, p);
    for (const WeightedTarget& target : targets) {
      load_block(target.deltas, first + done, n, d);
      for (std::uint64_t i = 0; i < n; ++i) {
        p[i].x = p[i].x + target.weight * d[i].x;
        p[i].y = p[i].y + target.weight * d[i].y;
        p[i].z = p[i].z + target.weight * d[i].z;
      }
    }
    if (!skinning.sets.empty()) {
      auto posed = pose(skinning, first + done, n, place, p);
      if (!posed) return posed;
      unbalanced += *posed;
    }
    for (std::uint64_t i = 0; i < n; ++i) {
      out[done + i] = {static_cast<float>(p[i].x), static_cast<float>(p[i].y),
                       static_cast<float>(p[i].z)};
    }
  }
  return unbalanced;
}

}  // namespace sightline::gltf
