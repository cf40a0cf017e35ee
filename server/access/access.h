#pragma once
/// Access control: what a client may request. Decided from the head of a request alone, before its
/// body is read and before its route or scene is searched.

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>

#include "server/access/key_ring.h"
#include "server/http/request_head.h"

namespace sightline {

/// kOpen: GET and HEAD of /healthz, /readyz, /docs and what that page is made of. kRead: other GET,
/// HEAD and OPTIONS, and POST, which asks; but not of /v1/scenes, which loads. kWrite: everything
/// else.
Access needed_access(std::string_view method, std::string_view target);

/// Thread-safe. Before the first call of `use` every request is allowed.
class AccessRules {
 public:
  /// Replaces the key ring. An empty ring allows only requests that need no key (Access::kOpen).
  /// Sets Key::revoked of each earlier key that the new ring lacks or gives less access; operations
  /// in progress under that key observe the flag.
  void use(KeyRing keys);
  /// Stores the client's name in `head` and erases the key. UNAUTHORIZED (401): no good key where
  /// one is needed; the answer does not depend on the request. FORBIDDEN (403): a read key for a
  /// request that changes something. Where the path or the request id contains a key, it is hidden
  /// from the log: a key of the ring as the whole text, or the key of this request anywhere in it.
  std::optional<RequestFault> admit(RequestHead& head) const;
  /// Whether a text is a key of the ring, or holds what make_key makes. Cost: one SHA-256.
  bool is_key(std::string_view text) const;

 private:
  std::shared_ptr<const KeyRing> keys() const;

  mutable std::mutex mutex_;
  std::shared_ptr<const KeyRing> keys_;
};

}  // namespace sightline
