#pragma once
/// Members of an answer beside the hits, if they were requested.

#include <string>

#include "core/query/query_work.h"
#include "core/query/ray_batch.h"
#include "core/query/selection_warning.h"

namespace sightline {

/// The work of one request.
struct WorkReport {
  QueryWork work;
  std::uint64_t parse_us = 0, trace_us = 0, describe_us = 0, print_us = 0;
};

/// {"nodes":..,"blocks":..,"placements":..,"exact":..,"trees_built":..,"microseconds":{"parse":..,
/// "trace":..,"describe":..,"print":..}}
std::string encode_work(const WorkReport& report);

/// [{"ray":17,"code":"RAY_DIRECTION_ZERO"}]
std::string encode_invalid(const InvalidRays& invalid);

/// [{"code":"SELECTION_EMPTY","pointer":"/include/names/0","message":".."}]
std::string encode_warnings(const SelectionWarnings& warnings);

/// For a header: {"count":2,"warnings":[..]} with the first of them, at most 4096 bytes of ASCII.
std::string encode_warnings_header(const SelectionWarnings& warnings);

/// Adds a member behind those of an object that has some already.
void add_member(std::string& object, std::string_view name, std::string_view json);

}  // namespace sightline

// Tests: tests/integration/selections_test.py
