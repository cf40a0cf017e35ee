#include "server/routes/preconditions.h"

#include <algorithm>
#include <string_view>

#include "server/http/ascii.h"

namespace sightline {
namespace {

/// The tags of the store have neither commas nor spaces: what another one is cut into is nobody's.
void add_tags(std::string_view list, bool takes_weak, TagList& tags) {
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(','), list.size());
    std::string_view tag = trimmed(list.substr(0, end));
    list.remove_prefix(std::min(end + 1, list.size()));
    if (tag == "*") tags.any = true;
    if (takes_weak && tag.starts_with("W/")) tag.remove_prefix(2);
    if (tag.size() > 1 && tag.front() == '"' && tag.back() == '"')
      tags.tags.emplace_back(tag.substr(1, tag.size() - 2));
  }
}

std::optional<TagList> tags_of(const std::optional<std::string>& list, bool takes_weak) {
  if (!list) return std::nullopt;
  TagList tags;
  add_tags(*list, takes_weak, tags);
  return tags;
}

}  // namespace

Precondition precondition_of(const Exchange& exchange) {
  return {tags_of(exchange.head.if_match, false), tags_of(exchange.head.if_none_match, true)};
}

}  // namespace sightline
