#include "server/access/access.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/http/ascii.h"
#include "server/http/router.h"

namespace sightline {
namespace {

/// [RFC6750] 2.1, the scheme in any case as [RFC9110] 11.1 has it. Empty where it is none.
std::string_view bearer_token(std::string_view authorization) {
  constexpr std::string_view kScheme = "bearer ";
  if (authorization.size() <= kScheme.size()) return {};
  if (!equals_caseless(authorization.substr(0, kScheme.size()), kScheme)) return {};
  authorization.remove_prefix(kScheme.size());
  return authorization.substr(std::min(authorization.find_first_not_of(' '), authorization.size()));
}

bool is_read(std::string_view method) {
  return method == "GET" || method == "HEAD" || method == "OPTIONS";
}

/// Health, and pages that are the same on every server: they ask for what they show, with a key.
bool is_open(const std::vector<std::string>& path) {
  if (path.size() == 1) {
    constexpr std::array<std::string_view, 12> kOpen{"",         "boot.js",  "page.js", "page.css",
                                                     "learn",    "learn.js", "status",  "status.js",
                                                     "guide.js", "docs",     "healthz", "readyz"};
    return std::find(kOpen.begin(), kOpen.end(), path[0]) != kOpen.end();
  }
  if (path[0] != "docs") return false;
  if (path.size() <= 3 && path.back().ends_with(".md")) return true;
  return path.size() == 2 &&
         (path[1] == "app.js" || path[1] == "style.css" || path[1] == "documents.json.gz");
}

/// Whether a text must not be shown. `shown` is the good key of the request, or empty.
bool tells_key(const KeyRing& ring, std::string_view shown, const std::string& text) {
  if (text.empty()) return false;
  return (!shown.empty() && text.find(shown) != std::string::npos) || ring.find(text) != nullptr;
}

/// The part of a path that logs show: the name of a scene in /v1/scenes/{id}.
std::string shown_part(std::string_view target) {
  std::vector<std::string> path;
  return split_path(target, path) && path.size() > 2 ? std::move(path[2]) : std::string();
}

}  // namespace

Access needed_access(std::string_view method, std::string_view target) {
  std::vector<std::string> path;
  const bool is_path = split_path(target, path);
  // A job is its client's own.
  const bool is_job = is_path && path.size() == 3 && path[0] == "v1" && path[1] == "jobs";
  if (!is_read(method) && method != "POST" && !(method == "DELETE" && is_job))
    return Access::kWrite;
  if (!is_path) return Access::kRead;
  if (method == "POST") {
    const bool loads = path == std::vector<std::string>{"v1", "scenes"};
    return loads ? Access::kWrite : Access::kRead;
  }
  return is_read(method) && method != "OPTIONS" && is_open(path) ? Access::kOpen : Access::kRead;
}

void AccessRules::use(KeyRing keys) {
  const std::lock_guard hold(mutex_);
  if (keys_) keys.succeed(*keys_);
  keys_ = std::make_shared<const KeyRing>(std::move(keys));
}

std::shared_ptr<const KeyRing> AccessRules::keys() const {
  const std::lock_guard hold(mutex_);
  return keys_;
}

bool AccessRules::is_key(std::string_view text) const {
  const auto ring = keys();
  return holds_key(text) || (ring && ring->find(text) != nullptr);
}

std::optional<RequestFault> AccessRules::admit(RequestHead& head) const {
  const std::string authorization = std::exchange(head.authorization, {});
  const auto ring = keys();
  if (!ring) {
    head.access = Access::kWrite;
    return std::nullopt;
  }
  const std::string_view token = bearer_token(authorization);
  const Key* key = ring->find(token);
  const std::string_view shown = key != nullptr ? token : std::string_view();
  if (tells_key(*ring, shown, head.request_id)) head.request_id.clear();
  head.hides_path = tells_key(*ring, shown, shown_part(head.target));
  head.access = key == nullptr ? Access::kOpen : key->access;
  if (key != nullptr) {
    head.key_name = key->name;
    head.revoked = key->revoked;
  }
  const Access needed = needed_access(head.method, head.target);
  if (needed <= head.access) return std::nullopt;
  if (key == nullptr)
    return RequestFault{401, "UNAUTHORIZED",
                        "this needs a key: send it in a header \"Authorization: Bearer KEY\""};
  return RequestFault{403, "FORBIDDEN", "this needs a key that may write"};
}

}  // namespace sightline
