#pragma once
/// A count in Draco's bytes that nothing else bounds.
///
/// Where texture coordinates are predicted from positions, a bit for each says on which side of an
/// edge it lies. The number of bits is stated on its own behind the coordinates, and the library
/// makes as many as it says, 2^31 from no bytes, before it looks whether they are needed.

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
