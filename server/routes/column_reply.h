#pragma once
/// Answers of columns in the form that a client accepts: bytes or a table.

#include <optional>
#include <string>

#include "core/base/result.h"
#include "proto/table_format.h"
#include "server/http/exchange.h"

namespace sightline {

/// The table that the client accepts, alone; a point cloud only if `has_clouds`.
std::optional<TableFormat> wanted_table(const Exchange& exchange, bool has_clouds);

/// Reserves memory and encodes a binary answer as a table. Errors: those of Exchange::reserve and
/// encode_column_table.
Result<std::string> table_of_columns(const Exchange& exchange, TableFormat format,
                                     const std::string& answer);

/// If the client accepts bytes or a table alone, answers with what encode() returns, a binary
/// answer, and returns true.
template <class Encode>
bool reply_columns(Exchange& exchange, const Encode& encode);

/// reply_columns for an encoded answer. Precondition: the client accepts bytes or a table.
void reply_encoded_columns(Exchange& exchange, std::string answer);
/// True if the client accepts bytes or a table of columns, alone.
bool wants_columns(const Exchange& exchange);

template <class Encode>
bool reply_columns(Exchange& exchange, const Encode& encode) {
  if (!wants_columns(exchange)) return false;
  reply_encoded_columns(exchange, encode());
  return true;
}

}  // namespace sightline

// Tests: tests/integration/tables_test.py
