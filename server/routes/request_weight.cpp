#include "server/routes/request_weight.h"

#include <algorithm>
#include <initializer_list>

namespace sightline {
namespace {

bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

bool ends_in(std::string_view path, std::initializer_list<std::string_view> names) {
  return std::any_of(names.begin(), names.end(),
                     [&](std::string_view name) { return path.ends_with(name); });
}

}  // namespace

Weight weigh_request(const RequestHead& head, std::string_view body) {
  // A query part may hold anything, the name of a cheap question too.
  const std::string_view path = std::string_view(head.target).substr(0, head.target.find('?'));
  // Also while all workers are busy.
  if (head.target == "/healthz" && body.empty()) return Weight::kInline;
  // A few bytes make millions of rays; a backslash may spell the same word.
  if (body.size() > kLittleBody || contains(path, "/nodes") ||
      ends_in(path, {"/animations", "/geometry", "/selfcheck", "/bvh"}) ||
      contains(body, "generator") || contains(body, "\\")) {
    return Weight::kBulk;
  }
  const bool fits = head.method == "POST" && head.coding == Coding::kIdentity &&
                    ends_in(path, {"/rays:closest", "/rays:any", "/rays:count"});
  return fits ? Weight::kInline : Weight::kShort;
}

}  // namespace sightline
