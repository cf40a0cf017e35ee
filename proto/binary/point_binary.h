#pragma once
/// Points and what is known of them as bytes: docs/reference/binary.md has the tables.

#include <string>
#include <string_view>

#include "proto/json/point_json.h"

namespace sightline {

/// The fields of a binary request without "fields": no texts.
inline constexpr FieldSet kDefaultBinaryNearestFields{HitField::kDistance, HitField::kInstance,
                                                      HitField::kPrimitive, HitField::kTriangle};

/// As decode_rays_binary. Errors besides: POINT_NOT_FINITE, those of decode_points.
Result<PointQuery> decode_points_binary(std::string_view body, const PointJsonRules& rules);

/// The functions of point_json.h as bytes; "unreliable" is returned separately.
std::string encode_inside_binary(const InsideColumns& columns);
std::string encode_signed_distances_binary(const InsideColumns& columns,
                                           std::span<const double> distance);

}  // namespace sightline

// Tests: tests/integration/binary_test.py
