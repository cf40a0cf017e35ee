#pragma once
/// Reads EXT_mesh_gpu_instancing: a node that places its mesh many times.

#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/affine.h"
#include "core/import/gltf/accessor.h"
#include "core/import/gltf/gltf_document.h"

namespace sightline::gltf {

/// Returns the placements of a node relative to the node; empty if the node does not have the
/// extension. Instance i is from_trs(translation_i, rotation_i, scale_i) in float64. Values are
/// widened from float32, or decoded from normalised integers. An absent attribute is the identity.
/// TRANSLATION and SCALE are float32 VEC3, ROTATION is VEC4 of float32 or normalised i8 or i16.
///
/// room    number of instances that the limits still allow
///
/// Errors: GLTF_INSTANCING_INVALID, GLTF_LIMIT_INSTANCES, GLTF_TRANSFORM_INVALID, those of
/// AccessorReader::view.
Result<std::optional<std::vector<Affine>>> read_placements(const GltfDocument& document,
                                                           std::size_t node,
                                                           AccessorReader& accessors,
                                                           std::uint64_t room);

}  // namespace sightline::gltf
