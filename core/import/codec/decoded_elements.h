#pragma once
/// DecodedElements: the packed numbers that a decoder writes, in a component type of glTF.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sightline::gltf {

/// The component types of glTF accessors, with their codes in files.
enum class Component : std::uint16_t {
  kI8 = 5120,
  kU8 = 5121,
  kI16 = 5122,
  kU16 = 5123,
  kU32 = 5125,
  kF32 = 5126
};

/// Packed elements of `components` numbers each, as a decoder writes them.
struct DecodedElements {
  Component component = Component::kF32;
  std::uint32_t components = 0;  ///< numbers of an element
  std::vector<std::byte> bytes;  ///< one element after the other, without padding
};

/// The number of bytes of one component.
inline std::size_t component_bytes(Component component) {
  switch (component) {
    case Component::kI8:
    case Component::kU8:
      return 1;
    case Component::kI16:
    case Component::kU16:
      return 2;
    default:
      return 4;
  }
}

}  // namespace sightline::gltf

// Tests: tests/unit/import/accessor_test.cpp
