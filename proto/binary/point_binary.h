#pragma once
/// Decodes points and encodes answers about them as bytes: docs/reference/binary.md.

#include <string>
#include <string_view>

#include "core/query/point_pairs.h"
#include "proto/json/point_json.h"

namespace sightline {

/// The fields of a binary request that does not choose any; none is text.
inline constexpr FieldSet kDefaultBinaryNearestFields{HitField::kDistance, HitField::kInstance,
                                                      HitField::kPrimitive, HitField::kTriangle};

/// Decodes a body of points; its options are those of decode_points. Errors: 400 BINARY_MALFORMED,
/// 413 POINTS_TOO_MANY, 422 POINT_NOT_FINITE, those of decode_points.
Result<PointQuery> decode_points_binary(std::string_view body, const PointJsonRules& rules);

// Binary forms of the functions of point_json.h. "unreliable" is not in the bytes; the caller sends
// it in a header.

/// For BoxPairing::kAll a value has a number for each point of `to`.
std::string encode_visibility_binary(const PointPairs& pairs,
                                     std::span<const std::uint8_t> visible);
std::string encode_inside_binary(const InsideColumns& columns);
std::string encode_signed_distances_binary(const InsideColumns& columns,
                                           std::span<const double> distance);

}  // namespace sightline

// Tests: tests/integration/binary_test.py
