#pragma once
/// Answers of columns as tables for other programs: CSV, NPY and NPZ.

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "proto/table_format.h"

namespace sightline {

/// Encodes a binary answer (docs/reference/binary.md) as a table; docs/reference/tables.md describes
/// it. `answer` is what a function of this room has encoded. Errors: REQUEST_TOO_LARGE for an .npz
/// file beyond 4 GiB. Preconditions: `format` is no point cloud.
Result<std::string> encode_column_table(TableFormat format, std::string_view answer);
/// The most bytes that encode_column_table allocates for an answer.
std::uint64_t bytes_of_column_table(std::string_view answer);

}  // namespace sightline

// Tests: tests/integration/tables_test.py
