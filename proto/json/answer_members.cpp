#include "proto/json/answer_members.h"

#include <nlohmann/json.hpp>

#include "proto/json/json_writer.h"

namespace sightline {

namespace {

/// A name that is not UTF-8 is repaired.
std::string encode_warning(const SelectionWarning& warning, bool ascii) {
  nlohmann::ordered_json entry;
  entry["code"] = kSelectionEmpty;
  entry["pointer"] = warning.pointer;
  entry["message"] = warning.message;
  return entry.dump(-1, ' ', ascii, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace

std::string encode_work(const WorkReport& report) {
  JsonWriter out(256);
  const auto member = [&](std::string_view before, std::uint64_t number) {
    out.raw(before);
    out.number(number);
  };
  member("{\"nodes\":", report.work.nodes);
  member(",\"blocks\":", report.work.blocks);
  member(",\"placements\":", report.work.placements);
  member(",\"exact\":", report.work.exact());
  member(",\"trees_built\":", report.work.trees_built);
  member(",\"microseconds\":{\"parse\":", report.parse_us);
  member(",\"trace\":", report.trace_us);
  member(",\"describe\":", report.describe_us);
  member(",\"print\":", report.print_us);
  out.raw("}}");
  return out.take();
}

std::string encode_invalid(const InvalidRays& invalid) {
  JsonWriter out(2 + invalid.number.size() * 48);
  out.raw('[');
  for (std::size_t i = 0; i < invalid.number.size(); ++i) {
    out.raw(i > 0 ? ",{\"ray\":" : "{\"ray\":");
    out.number(std::uint64_t{invalid.number[i]});
    out.raw(",\"code\":\"");
    out.raw(invalid.code[i]);
    out.raw("\"}");
  }
  out.raw(']');
  return out.take();
}

std::string encode_warnings(const SelectionWarnings& warnings) {
  std::string text = "[";
  for (const SelectionWarning& warning : warnings) {
    if (text.size() > 1) text += ',';
    text += encode_warning(warning, false);
  }
  return text + "]";
}

std::string encode_warnings_header(const SelectionWarnings& warnings) {
  constexpr std::size_t kMostBytes = 4096, kEnd = 2;
  std::string text = "{\"count\":" + std::to_string(warnings.size()) + ",\"warnings\":[";
  const std::size_t begin = text.size();
  for (const SelectionWarning& warning : warnings) {
    const std::string entry = encode_warning(warning, true);
    if (text.size() + 1 + entry.size() + kEnd > kMostBytes) break;
    if (text.size() > begin) text += ',';
    text += entry;
  }
  return text + "]}";
}

void add_member(std::string& object, std::string_view name, std::string_view json) {
  object.pop_back();
  object.append(",\"").append(name).append("\":").append(json).append("}");
}

}  // namespace sightline
