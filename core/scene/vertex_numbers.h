#pragma once
/// Vertex data of a file other than positions. It affects no decision, and is read for hits whose
/// fields need it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace sightline {

enum class VertexAttribute : std::uint8_t {
  kNormal,  ///< 3 numbers, in the mesh's own space, as stored: of any length
  kUv,      ///< TEXCOORD_0: 2 numbers
  kColour,  ///< COLOR_0: 3 or 4 numbers, linear
};
inline constexpr std::size_t kVertexAttributes = 3;

/// One attribute of a primitive's vertices, wherever it lies. May be read by many threads at once.
class VertexNumbers {
 public:
  virtual ~VertexNumbers() = default;
  /// 2, 3 or 4.
  virtual std::uint32_t components() const = 0;
  /// Writes as many numbers, of the vertex with this number in the file; adds to `touched` the
  /// bytes of the file that were read for it. False: they were compressed, and cannot be decoded.
  /// Throws std::bad_alloc. Precondition: a triangle of the primitive uses the vertex.
  virtual bool load(std::uint64_t vertex, double* out, std::uint64_t& touched) const = 0;
  /// In memory, beside the file's own.
  virtual std::uint64_t bytes() const = 0;
};

/// The attributes of a primitive.
struct PrimitiveAttributes {
  /// Vertex i of the mesh is vertex i + first_vertex (modulo 2^32) of the file.
  std::uint32_t first_vertex = 0;
  /// By VertexAttribute; null where the file has none that can be used.
  std::array<std::shared_ptr<const VertexNumbers>, kVertexAttributes> numbers;

  const VertexNumbers* of(VertexAttribute attribute) const {
    return numbers[static_cast<std::size_t>(attribute)].get();
  }
};

}  // namespace sightline

// Tests: tests/integration/attributes_test.py
