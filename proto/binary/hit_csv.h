#pragma once
/// Hits as cells of CSV by RFC 4180.

#include <string>
#include <string_view>
#include <vector>

#include "proto/hit_columns.h"
#include "proto/hit_fields.h"

namespace sightline {

/// The names of the numbers of a column: "t", or "position_x", "position_y", "position_z". Those of
/// a column that is no field of hit_fields.def are "from_0", "from_1" and so on.
std::vector<std::string> part_names(std::string_view column, std::size_t width);

/// Appends the names of the columns of all fields, each with `prefix` before it and a comma behind
/// it. The caller ends the line.
void append_csv_names(std::string& out, std::string_view prefix, const HitAnswer& answer,
                      FieldSet fields);
/// Appends the values of slot `i`, each with a comma behind it. A value that is missing or not
/// finite is an empty cell. The caller ends the line.
void append_csv_cells(std::string& out, const HitAnswer& answer, FieldSet fields, std::size_t i);
/// Appends a number and a comma; a number that is not finite is an empty cell.
void append_csv_number(std::string& out, double value);

}  // namespace sightline

// Tests: tests/integration/tables_test.py
