#pragma once
/// Reads a count from Draco's bytes that the Draco library does not check before it allocates
/// memory.
///
/// If texture coordinates are predicted from positions, each has a bit that tells on which side of
/// an edge it lies. The stream states the number of bits after the coordinates. The library
/// allocates as many bits as stated, up to 2^31 even if no bytes follow, and checks only later if
/// the coordinates need so many.

#include <draco/core/decoder_buffer.h>

#include <cstdint>

namespace sightline::gltf {

/// Returns the number of bits that the library will allocate; 0 if the attribute is predicted in
/// another way, or if its bytes end before the number (then the library returns an error).
/// buffer      stands after the two bytes that name the prediction of an attribute
/// entries     number of values of the attribute
/// components  numbers in a value; two in a valid file
/// Cost        decodes the coordinates a second time.
std::uint64_t claimed_orientations(draco::DecoderBuffer buffer, std::uint64_t entries,
                                   int components);

}  // namespace sightline::gltf

// Tests: tests/unit/import/draco_mesh_test.cpp
