#pragma once
/// Bounds a count in Draco's bytes that nothing else bounds.
///
/// Where texture coordinates are predicted from positions, each has a bit that says on which side
/// of an edge it lies. The number of bits is stated separately behind the coordinates. The library
/// allocates as many as stated, up to 2^31 for no bytes, before it checks whether they are needed.

#include <draco/core/decoder_buffer.h>

#include <cstdint>

namespace sightline::gltf {

/// How many bits will be made. `buffer` stands behind the two bytes that name an attribute's
/// prediction, as where the library sets the prediction up. 0 when the attribute is predicted in
/// another way, or its bytes end before the number (then the library fails by itself).
/// entries     values of the attribute
/// components  of each; two, if the file is right
/// Cost        the coordinates are decoded once more, and thrown away.
std::uint64_t claimed_orientations(draco::DecoderBuffer buffer, std::uint64_t entries,
                                   int components);

}  // namespace sightline::gltf

// Tests: tests/unit/import/draco_mesh_test.cpp
