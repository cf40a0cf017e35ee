// Rays as lines: an error with a place, or rays that another parser reads alike, in whatever
// batches the lines came.
// Run:  scripts/stress.sh fuzz --target ray_lines_fuzz
//
// The first byte of an input says how the lines are cut into batches.

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

#include "proto/json/ray_lines.h"
#include "tests/fuzz/body_check.h"
#include "tests/fuzz/cuts.h"

using namespace sightline;

namespace {

using fuzz::require;
using nlohmann::json;

/// The rays of all batches, or nothing where one of them was refused.
std::optional<RayBatch> read(std::string_view text, unsigned seed, bool has_fields) {
  RayLines lines({.max_rays = 64, .has_fields = has_fields});
  fuzz::Cuts cuts(seed);
  RayBatch all;
  while (!text.empty()) {
    const std::size_t at = text.find('\n', cuts.next(text.size()) - 1);
    std::string batch(text.substr(0, std::min(at, text.size() - 1) + 1));
    text.remove_prefix(batch.size());
    const std::string sent = batch;
    const auto query = lines.decode(batch);
    require(batch == sent, "the lines are only read");
    if (!query) {
      fuzz::check_error(query.error());
      return std::nullopt;
    }
    require(query->layout == AnswerLayout::kLines, "lines are answered by lines");
    RayFault fault;
    require(check_rays(query->rays, fault), "rays have passed the border");
    if (query->normalize || query->marks_invalid) return std::nullopt;
    for (std::size_t i = 0; i < query->rays.size(); ++i) all.push_back(query->rays[i]);
  }
  return all;
}

/// The objects of the lines, without the options.
json objects_of(std::string_view text) {
  json rows = json::array();
  for (bool first = true; !text.empty(); first = false) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const json row = json::parse(line, nullptr, false);
    require(row.is_object(), "what is accepted is an object in each line");
    if (!first || !row.contains("options")) rows.push_back(row);
  }
  return rows;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const bool has_fields = data[0] % 2 == 0;
  const auto whole = read(text, 0, has_fields);
  const auto parts = read(text, data[0] + 1u, has_fields);
  require(whole.has_value() == parts.has_value(), "batches are judged alike");
  if (!whole) return 0;
  fuzz::check_same_rays(*whole, *parts);
  fuzz::check_rows(objects_of(text), *whole);
  return 0;
}
