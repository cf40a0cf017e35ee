#pragma once
/// Writes one hit as JSON. For files of this room only.

#include "proto/hit_columns.h"
#include "proto/json/json_writer.h"

namespace sightline {

/// Writes hit i: {"t":5,"triangle":12}, or null for a miss.
void write_row(JsonWriter& out, const HitAnswer& answer, FieldSet fields, std::size_t i);
/// An estimate of the bytes of one hit: 18 for each number, 12 for other values.
std::size_t expected_hit_bytes(FieldSet fields);

}  // namespace sightline

// Tests: tests/unit/proto/hit_json_test.cpp
