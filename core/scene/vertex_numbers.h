#pragma once
/// VertexNumbers: a vertex attribute of a file, other than positions. No decision depends on it; it
/// is read for hits whose requested fields need it.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace sightline {

/// The attributes that hits may need.
enum class VertexAttribute : std::uint32_t {
  kNormal,   ///< 3 numbers in mesh space, as stored, of any length
  kUv,       ///< TEXCOORD_0: 2 numbers
  kColour,   ///< COLOR_0: 3 or 4 numbers, linear
  kUv1,      ///< TEXCOORD_1: 2 numbers
  kTangent,  ///< TANGENT: 3 numbers in mesh space, and 1 or -1
  /// The first of SceneDescription::named_attributes; the others follow. 1 to 4 numbers.
  kNamed,
};
/// The attribute that is `index` in SceneDescription::named_attributes, and the reverse.
constexpr VertexAttribute named_attribute(std::size_t index) {
  return static_cast<VertexAttribute>(static_cast<std::size_t>(VertexAttribute::kNamed) + index);
}
/// Precondition: attribute >= VertexAttribute::kNamed.
constexpr std::size_t named_index(VertexAttribute attribute) {
  return static_cast<std::size_t>(attribute) - static_cast<std::size_t>(VertexAttribute::kNamed);
}

/// An attribute of a primitive's vertices: in the file's bytes, copied, or compressed. Thread-safe.
class VertexNumbers {
 public:
  virtual ~VertexNumbers() = default;
  /// The number of numbers per vertex, at most 4.
  virtual std::uint32_t components() const = 0;
  /// Writes components() numbers of a vertex to `out`; `vertex` is its number in the file. Adds to
  /// `touched` the bytes of the file that were read. Returns false if the data is compressed and
  /// cannot be decoded. Throws std::bad_alloc. Precondition: a triangle of the primitive uses the
  /// vertex.
  virtual bool load(std::uint64_t vertex, double* out, std::uint64_t& touched) const = 0;
  /// Bytes that the attribute needs in memory in addition to the file's bytes.
  virtual std::uint64_t bytes() const = 0;
};

/// The vertex attributes of a primitive.
struct PrimitiveAttributes {
  /// Vertex i of the mesh is vertex i + first_vertex (modulo 2^32) of the file.
  std::uint32_t first_vertex = 0;
  struct Entry {
    VertexAttribute attribute;
    std::shared_ptr<const VertexNumbers> numbers;
  };
  /// Those that are usable, ascending by attribute. No numbers are null.
  std::vector<Entry> entries;

  /// An attribute; null if the file has no usable one. Valid while this struct lives.
  const VertexNumbers* of(VertexAttribute attribute) const {
    const auto found = std::lower_bound(
        entries.begin(), entries.end(), attribute,
        [](const Entry& entry, VertexAttribute wanted) { return entry.attribute < wanted; });
    return found != entries.end() && found->attribute == attribute ? found->numbers.get() : nullptr;
  }
};

}  // namespace sightline

// Tests: tests/integration/attributes_test.py
