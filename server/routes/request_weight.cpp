#include "server/routes/request_weight.h"

#include <algorithm>
#include <array>

namespace sightline {
namespace {

/// So few bytes of JSON name some thirty rays.
constexpr std::size_t kLittle = 2 << 10;

bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

}  // namespace

bool walks_scene(const RequestHead& head) {
  const std::string_view path = std::string_view(head.target).substr(0, head.target.find('?'));
  return path.ends_with("/selfcheck") || path.ends_with("/bvh");
}

bool asks_for_little(const RequestHead& head, std::string_view body) {
  if (body.size() > kLittle) return false;
  // These walk over a whole scene.
  constexpr std::array<std::string_view, 4> kWalks{"/selfcheck", "/bvh", "/nodes", "/geometry"};
  if (std::any_of(kWalks.begin(), kWalks.end(),
                  [&](std::string_view part) { return contains(head.target, part); })) {
    return false;
  }
  // A few bytes make millions of rays; a backslash may spell the same word.
  return !contains(body, "generator") && !contains(body, "\\");
}

bool fits_the_door(const RequestHead& head, std::string_view body) {
  // Also while all workers have their hands full.
  if (head.target == "/healthz") return body.empty();
  if (head.method != "POST" || head.coding != Coding::kIdentity || !asks_for_little(head, body))
    return false;
  constexpr std::array<std::string_view, 3> kQuestions{"/rays:closest", "/rays:any", "/rays:count"};
  // A query part may hold anything, the name of a cheap question too.
  const std::string_view path = std::string_view(head.target).substr(0, head.target.find('?'));
  return std::any_of(kQuestions.begin(), kQuestions.end(),
                     [&](std::string_view question) { return path.ends_with(question); });
}

}  // namespace sightline
