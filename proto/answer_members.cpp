#include "proto/answer_members.h"

#include "proto/json_writer.h"

namespace sightline {

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

void add_member(std::string& object, std::string_view name, std::string_view json) {
  object.pop_back();
  object.append(",\"").append(name).append("\":").append(json).append("}");
}

}  // namespace sightline
