#pragma once
/// Points and what is known of them as bytes: docs/reference/binary.md has the tables.

#include <string>
#include <string_view>

#include "proto/point_json.h"

namespace sightline {

/// What a binary request without "fields" gets: no texts.
inline constexpr FieldSet kDefaultBinaryNearestFields{HitField::kDistance, HitField::kInstance,
                                                      HitField::kPrimitive, HitField::kTriangle};

/// As decode_rays_binary. Errors besides: POINT_NOT_FINITE, those of decode_points.
Result<PointQuery> decode_points_binary(std::string_view body, const PointJsonRules& rules);

/// As the functions of the same names in point_json.h; "unreliable" stands elsewhere.
std::string encode_inside_binary(const InsideColumns& columns);
std::string encode_signed_distances_binary(const InsideColumns& columns,
                                           std::span<const double> distance);

}  // namespace sightline
