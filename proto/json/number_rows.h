#pragma once
/// Reads short arrays of numbers from a JSON body: vectors, quaternions, planes. For files of this
/// room that use simdjson.

#include <optional>

#include "core/query/ray_batch.h"
#include "proto/json/json_reader.h"

namespace sightline {

/// Reads exactly `count` numbers, three or four, to `out`; null gives `open`, if that is given.
/// Returns false if the reader has an error.
bool read_numbers(JsonReader& reader, JsonReader::Value value, const JsonPointer& place,
                  double* out, int count, std::optional<double> open = std::nullopt);

inline Vec3d vector_of(const double* v) { return {v[0], v[1], v[2]}; }

/// Reads three numbers.
bool read_vector(JsonReader& reader, JsonReader::Value value, const JsonPointer& place, Vec3d& out);

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
