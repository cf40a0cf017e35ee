#pragma once
/// Encodes members of an answer other than hits, which a request may ask for.

#include <string>

#include "core/query/query_work.h"
#include "core/query/ray_batch.h"
#include "core/query/selection_warning.h"

namespace sightline {

/// The cost of a request, with the microseconds of its steps.
struct WorkReport {
  QueryWork work;
  std::uint64_t parse_us = 0, trace_us = 0, describe_us = 0, print_us = 0;
};

/// Returns {"nodes":..,"blocks":..,"placements":..,"exact":..,"trees_built":..,
/// "microseconds":{"parse":..,"trace":..,"describe":..,"print":..}}.
std::string encode_work(const WorkReport& report);

/// Returns [{"ray":17,"code":"RAY_DIRECTION_ZERO"}].
std::string encode_invalid(const InvalidRays& invalid);

/// Encodes the value of "warnings", one element for each selector that matches nothing:
/// [{"code":"SELECTION_EMPTY","pointer":"/include/names/0","message":".."}]. Without any: [].
std::string encode_warnings(const SelectionWarnings& warnings);

/// The value of the header X-Sightline-Warnings: {"count":2,"warnings":[..]} with the number of all
/// warnings and the first of them, at most 4096 bytes of ASCII.
std::string encode_warnings_header(const SelectionWarnings& warnings);

/// Appends a member to the text of a JSON object that has at least one member. `json` is its value
/// as JSON; `name` needs no escape.
void add_member(std::string& object, std::string_view name, std::string_view json);

}  // namespace sightline

// Tests: tests/integration/selections_test.py
