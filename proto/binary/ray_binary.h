#pragma once
/// Decodes rays from bytes: docs/reference/binary.md.

#include <string_view>

#include "core/base/result.h"
#include "proto/json/ray_json.h"

namespace sightline {

/// The media type of binary requests and answers.
inline constexpr std::string_view kBinaryMediaType = "application/octet-stream";

/// The fields of a binary request that does not choose any; none is text.
inline constexpr FieldSet kDefaultBinaryFields{HitField::kT, HitField::kInstance,
                                               HitField::kPrimitive, HitField::kTriangle};
/// Decodes a body of rays. float32 numbers are converted to float64 without error. The query does
/// not refer to the body.
/// usual  a query without rays, whose options a body without options has; null: the defaults
/// Errors, 400: BINARY_MALFORMED (wrong magic or flags, or a length that differs from the header's;
/// the message has both). 422: FIELD_IS_TEXT, the codes of the options' JSON, and those of
/// check_rays with the pointer /rays/N/... . 413: RAYS_TOO_MANY.
Result<RayQuery> decode_rays_binary(std::string_view body, const RayJsonRules& rules,
                                    const RayQuery* usual = nullptr);

}  // namespace sightline
