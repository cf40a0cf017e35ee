#pragma once
/// Reads short arrays of numbers from a JSON body: vectors, quaternions, planes. For files of this
/// room that use simdjson.

#include <array>
#include <optional>

#include "core/query/ray_batch.h"
#include "proto/json/json_reader.h"

namespace sightline {

/// Reads exactly `count` numbers, three or four, to `out`, which has room for them. If `open` is
/// given, a null in place of a number gives `open`. Returns false if the reader has an error.
bool read_numbers(JsonReader& reader, JsonReader::Value value, const JsonPointer& place,
                  double* out, int count, std::optional<double> open = std::nullopt);

/// The vector of three numbers.
inline Vec3d vector_of(const double* v) { return {v[0], v[1], v[2]}; }

/// Reads three numbers. Returns false if the reader has an error.
bool read_vector(JsonReader& reader, JsonReader::Value value, const JsonPointer& place, Vec3d& out);

/// Reads the three axes of a box. Returns false if the reader has an error.
bool read_axes(JsonReader& reader, JsonReader::Value value, const JsonPointer& place,
               std::array<Vec3d, 3>& out);

/// The text of BOX_ROTATION_NOT_UNIT.
inline constexpr const char* kRotationNotUnit =
    "the squared length of a rotation [x,y,z,w] must be within 1% of 1";

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
