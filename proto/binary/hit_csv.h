#pragma once
/// Hits as cells of CSV by RFC 4180.

#include <string>
#include <string_view>
#include <vector>

#include "proto/hit_columns.h"
#include "proto/hit_fields.h"

namespace sightline {

/// The names of the columns of a field: "t", or "position_x", "position_y", "position_z".
std::vector<std::string> hit_column_names(HitField field);

/// Appends the names of the columns of all fields, each with `prefix` before it and a comma behind
/// it. The caller ends the line.
void append_csv_names(std::string& out, std::string_view prefix, FieldSet fields);
/// Appends the values of slot `i`, each with a comma behind it. A value that is missing or not
/// finite is an empty cell. The caller ends the line.
void append_csv_cells(std::string& out, const HitAnswer& answer, FieldSet fields, std::size_t i);
/// Appends a number and a comma; a number that is not finite is an empty cell.
void append_csv_number(std::string& out, double value);

}  // namespace sightline

// Tests: tests/integration/tables_test.py
