#include "core/import/gltf/accessor.h"

#include <algorithm>
#include <cstring>

#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

template <class T>
T load(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

/// Numbers per element; the smaller matrices, whose columns may be padded, are never read.
std::uint32_t components_of(int type) {
  switch (type) {
    case TINYGLTF_TYPE_SCALAR:
      return 1;
    case TINYGLTF_TYPE_VEC2:
      return 2;
    case TINYGLTF_TYPE_VEC3:
      return 3;
    case TINYGLTF_TYPE_VEC4:
      return 4;
    case TINYGLTF_TYPE_MAT4:
      return 16;
    default:
      return 0;
  }
}

std::string accessor_pointer(std::size_t accessor) {
  return "/accessors/" + std::to_string(accessor);
}

Error wrong(std::size_t accessor, const std::string& what) {
  return invalid("GLTF_ACCESSOR_INVALID", "accessor " + std::to_string(accessor) + ": " + what,
                 accessor_pointer(accessor));
}

}  // namespace

std::size_t AccessorView::element_bytes() const { return component_bytes(component) * components; }

std::int64_t load_integer(const std::byte* at, Component component) {
  switch (component) {
    case Component::kI8:
      return load<std::int8_t>(at);
    case Component::kU8:
      return load<std::uint8_t>(at);
    case Component::kI16:
      return load<std::int16_t>(at);
    case Component::kU16:
      return load<std::uint16_t>(at);
    default:
      return load<std::uint32_t>(at);
  }
}

double load_number(const std::byte* at, Component component, bool normalized) {
  if (component == Component::kF32) return static_cast<double>(load<float>(at));
  const auto c = static_cast<double>(load_integer(at, component));
  if (!normalized) return c;
  switch (component) {
    case Component::kI8:
      return std::max(c / 127, -1.0);
    case Component::kU8:
      return c / 255;
    case Component::kI16:
      return std::max(c / 32767, -1.0);
    case Component::kU16:
      return c / 65535;
    default:
      return c / 4294967295.0;
  }
}

std::uint64_t sparse_index(const AccessorView& view, std::uint64_t entry) {
  const std::size_t size = component_bytes(view.sparse_component);
  return static_cast<std::uint64_t>(
      load_integer(view.sparse_indices + entry * size, view.sparse_component));
}

std::uint64_t sparse_lower_bound(const AccessorView& view, std::uint64_t index) {
  std::uint64_t low = 0, high = view.sparse_count;
  while (low < high) {
    const std::uint64_t middle = low + (high - low) / 2;
    if (sparse_index(view, middle) < index) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

void load_element(const AccessorView& view, std::uint64_t index, std::uint32_t wanted,
                  double* out) {
  const std::byte* at = view.base != nullptr ? view.base + index * view.stride : nullptr;
  if (view.sparse_count > 0) {
    const std::uint64_t entry = sparse_lower_bound(view, index);
    if (entry < view.sparse_count && sparse_index(view, entry) == index) {
      at = view.sparse_values + entry * view.element_bytes();
    }
  }
  const std::size_t size = component_bytes(view.component);
  for (std::uint32_t c = 0; c < wanted; ++c) {
    out[c] = at != nullptr ? load_number(at + c * size, view.component, view.normalized) : 0;
  }
}

Status AccessorReader::check(std::size_t index, const char* part, const Extent& extent,
                             std::uint64_t bytes) {
  const auto& view = document_.model.bufferViews[static_cast<std::size_t>(extent.view)];
  const std::string place = "accessor " + std::to_string(index) + part;
  // No sum overflows: the checker bounds every number by 2^53 and strides by 252.
  const std::uint64_t stride = extent.stride_or_zero != 0 ? extent.stride_or_zero : extent.element;
  const std::uint64_t needed = extent.offset + (extent.count - 1) * stride + extent.element;
  if (needed > bytes) {
    return invalid("GLTF_ACCESSOR_OUT_OF_BOUNDS",
                   place + ": needs " + std::to_string(needed) + " bytes, bufferView " +
                       std::to_string(extent.view) + " has " + std::to_string(bytes),
                   accessor_pointer(index));
  }
  // Readers differ where an accessor is not aligned in its bufferView, not where the bufferView is
  // not aligned in its buffer.
  if (extent.offset % extent.alignment != 0 || stride % extent.alignment != 0) {
    return wrong(index, std::string(part) + "starts at byte " + std::to_string(extent.offset) +
                            " of its bufferView with stride " + std::to_string(stride) +
                            ", its components need a multiple of " +
                            std::to_string(extent.alignment));
  }
  const bool is_decoded = views_.is_meshopt(static_cast<std::size_t>(extent.view));
  if (view.byteOffset % extent.alignment != 0 && !is_decoded) unaligned_.insert(extent.view);
  return success();
}

Result<const std::byte*> AccessorReader::locate(std::size_t index, const char* part,
                                                const Extent& extent) {
  auto bytes = views_.bytes(static_cast<std::size_t>(extent.view));
  if (!bytes) return bytes.error();
  if (Status status = check(index, part, extent, bytes->size()); !status) return status.error();
  return bytes->data() + extent.offset;
}

Status AccessorReader::attach_sparse(std::size_t index, AccessorView& view) {
  const auto& sparse = document_.model.accessors[index].sparse;
  const auto count = static_cast<std::uint64_t>(sparse.count);
  if (count > view.count) {
    return wrong(index, "sparse.count is " + std::to_string(count) + ", count is " +
                            std::to_string(view.count));
  }
  view.sparse_component = static_cast<Component>(sparse.indices.componentType);
  if (view.sparse_component != Component::kU8 && view.sparse_component != Component::kU16 &&
      view.sparse_component != Component::kU32) {
    return wrong(index, "sparse.indices.componentType must be 5121, 5123 or 5125, it is " +
                            std::to_string(sparse.indices.componentType));
  }
  const std::size_t size = component_bytes(view.sparse_component);
  auto indices =
      locate(index, " (sparse.indices)",
             {sparse.indices.bufferView, static_cast<std::uint64_t>(sparse.indices.byteOffset),
              count, size, 0, size});
  if (!indices) return indices.error();
  auto values =
      locate(index, " (sparse.values)",
             {sparse.values.bufferView, static_cast<std::uint64_t>(sparse.values.byteOffset), count,
              view.element_bytes(), 0, component_bytes(view.component)});
  if (!values) return values.error();
  view.sparse_count = count;
  view.sparse_indices = *indices;
  view.sparse_values = *values;
  for (std::uint64_t entry = 0; entry < count; ++entry) {
    const std::uint64_t at = sparse_index(view, entry);
    if (at >= view.count || (entry > 0 && at <= sparse_index(view, entry - 1))) {
      return wrong(index, "sparse index " + std::to_string(entry) + " is " + std::to_string(at) +
                              ", it must be larger than the previous one and below " +
                              std::to_string(view.count));
    }
  }
  return success();
}

AccessorView AccessorReader::stated_type(std::size_t index) const {
  const tinygltf::Accessor& accessor = document_.model.accessors[index];
  AccessorView view;
  view.accessor = static_cast<std::uint32_t>(index);
  view.count = accessor.count;
  view.component = static_cast<Component>(accessor.componentType);
  view.components = components_of(accessor.type);
  view.normalized = accessor.normalized;
  view.stride = view.element_bytes();
  return view;
}

Result<AccessorView> AccessorReader::stated(std::size_t index) const {
  const tinygltf::Accessor& accessor = document_.model.accessors[index];
  AccessorView view = stated_type(index);
  if (view.components == 0) return wrong(index, "a matrix is not expected here");
  if (!document_.has_view(accessor)) return view;
  const auto& source = document_.model.bufferViews[static_cast<std::size_t>(accessor.bufferView)];
  if (source.byteStride == 0) return view;
  if (source.byteStride < view.stride) {
    return wrong(index, "an element has " + std::to_string(view.stride) + " bytes, bufferView " +
                            std::to_string(accessor.bufferView) + " has a stride of " +
                            std::to_string(source.byteStride));
  }
  view.stride = source.byteStride;
  return view;
}

AccessorReader::Extent AccessorReader::extent_of(std::size_t index,
                                                 const AccessorView& view) const {
  const tinygltf::Accessor& accessor = document_.model.accessors[index];
  return {accessor.bufferView,  accessor.byteOffset, view.count,
          view.element_bytes(), view.stride,         component_bytes(view.component)};
}

Result<AccessorView> AccessorReader::view_to_decode(std::size_t index) {
  auto view = stated(index);
  if (!view) return view;
  const Extent extent = extent_of(index, *view);
  const auto& source = document_.model.bufferViews[static_cast<std::size_t>(extent.view)];
  Status status = check(index, "", extent, source.byteLength);
  if (!status) return status.error();
  view->is_decoded = true;
  return view;
}

Result<AccessorView> AccessorReader::view(std::size_t index) {
  const tinygltf::Accessor& accessor = document_.model.accessors[index];
  auto found = stated(index);
  if (!found) return found;
  AccessorView& view = *found;
  if (document_.has_view(accessor)) {
    auto base = locate(index, "", extent_of(index, view));
    if (!base) return base.error();
    view.base = *base;
  } else if (view.count > limits_.zero_filled) {
    return beyond_limit(
        "ZERO_FILLED", "accessor " + std::to_string(index) + ": elements without bytes in the file",
        view.count, limits_.zero_filled, accessor_pointer(index));
  }
  if (accessor.sparse.isSparse) {
    if (Status status = attach_sparse(index, view); !status) return status.error();
  }
  return view;
}

Result<AccessorView> AccessorReader::view_of_decoded(std::size_t index) const {
  AccessorView view = stated_type(index);
  if (view.components == 0) return wrong(index, "a matrix is not expected here");
  if (document_.model.accessors[index].sparse.isSparse) {
    return wrong(index, "compressed elements cannot be sparse");
  }
  view.is_decoded = true;
  return view;
}

Result<AccessorView> AccessorReader::view(std::size_t index, const DecodedElements& decoded) {
  auto found = view_of_decoded(index);
  if (!found) return found;
  AccessorView& view = *found;
  view.base = decoded.bytes.data();
  if (view.component != decoded.component || view.components != decoded.components) {
    return wrong(index, "the compressed elements are of another type");
  }
  if (view.count * view.stride != decoded.bytes.size()) {
    return wrong(index, "its elements take " + std::to_string(view.count * view.stride) +
                            " bytes, the compressed ones " + std::to_string(decoded.bytes.size()));
  }
  return view;
}

std::span<const std::byte> AccessorReader::count(const AccessorView& view, std::uint64_t first,
                                                 std::uint64_t count,
                                                 std::uint64_t TouchedBytes::*kind) {
  const auto& accessor = document_.model.accessors[view.accessor];
  const std::size_t element = view.element_bytes();
  const auto is_mapped = [&](int number) {
    return views_.is_mapped(static_cast<std::size_t>(number));
  };
  std::span<const std::byte> bytes;
  if (count > 0 && view.base != nullptr && !view.is_decoded && is_mapped(accessor.bufferView)) {
    touched_.*kind += count * element;
    bytes = {view.base + first * view.stride, (count - 1) * view.stride + element};
  }
  if (view.sparse_count > 0) {
    if (is_mapped(accessor.sparse.indices.bufferView)) {
      touched_.*kind += view.sparse_count * component_bytes(view.sparse_component);
    }
    if (is_mapped(accessor.sparse.values.bufferView)) {
      touched_.*kind += view.sparse_count * element;
    }
  }
  return bytes;
}

void AccessorReader::announce(const AccessorView& view, std::uint64_t first, std::uint64_t count,
                              std::uint64_t TouchedBytes::*kind) {
  will_need(this->count(view, first, count, kind));
}

}  // namespace sightline::gltf
