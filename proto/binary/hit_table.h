#pragma once
/// Encodes hits as a table for other programs: CSV, PLY, PCD, NPY and NPZ.
/// docs/reference/tables.md describes each.

#include <span>
#include <string>
#include <string_view>

#include "core/query/hit_batch.h"
#include "proto/hit_fields.h"
#include "proto/hit_terms.h"
#include "proto/table_format.h"

namespace sightline {

/// Encodes the slots. The order of columns is that of all_hit_fields(); texts are in CSV alone.
/// Preconditions: `fields` has kPosition for a point cloud, and no text except for CSV.
std::string encode_hit_table(TableFormat format, const HitBatch& hits,
                             std::span<const HitDetail> details, const HitTerms& terms,
                             FieldSet fields);

}  // namespace sightline

// Tests: tests/integration/tables_test.py
