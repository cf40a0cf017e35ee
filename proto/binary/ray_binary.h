#pragma once
/// Rays as bytes: docs/reference/binary.md has the table.

#include <string_view>

#include "core/base/result.h"
#include "proto/json/ray_json.h"

namespace sightline {

inline constexpr std::string_view kBinaryMediaType = "application/octet-stream";

/// The fields of a binary request without "fields": no texts.
inline constexpr FieldSet kDefaultBinaryFields{HitField::kT, HitField::kInstance,
                                               HitField::kPrimitive, HitField::kTriangle};
/// `usual`: the options of a body that has none; without rays. The body is only read. Any float32
/// is accepted and becomes the same float64. Errors, 400: BINARY_MALFORMED (magic, flags, or a
/// length other than the header says; with both numbers). 422: FIELD_IS_TEXT, the codes of the
/// options' JSON and of check_rays, whose pointer is /rays/N/... . 413: RAYS_TOO_MANY.
Result<RayQuery> decode_rays_binary(std::string_view body, const RayJsonRules& rules,
                                    const RayQuery* usual = nullptr);

}  // namespace sightline
