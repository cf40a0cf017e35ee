#pragma once
/// Access control: which requests a client may make. It is decided from the head of a request
/// alone, before the server reads its body or finds its route and scene.

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>

#include "server/access/key_ring.h"
#include "server/http/request_head.h"

namespace sightline {

/// The access that a request needs. kOpen: GET and HEAD of /healthz, /readyz, /docs and the files
/// of that page. kRead: other GET, HEAD and OPTIONS, and POST to routes that answer questions; not
/// POST to /v1/scenes, which loads a scene. kWrite: all other requests.
Access needed_access(std::string_view method, std::string_view target);

/// The rules of a server. Thread-safe. Before the first call of `use` every request is allowed.
class AccessRules {
 public:
  /// Replaces the key ring. With an empty ring, only requests that need no key (Access::kOpen) are
  /// allowed. Sets Key::revoked of each earlier key that the new ring lacks or gives less access;
  /// operations in progress under that key observe the flag.
  void use(KeyRing keys);
  /// Checks the key of a request; empty if the request is allowed. Stores the name of the key in
  /// `head`, and erases the key from it. Faults: UNAUTHORIZED (401): a key is needed, and there is
  /// none or an invalid one; FORBIDDEN (403): a read key for a request that changes something.
  /// Marks the path or the request id as hidden from the log if it is a key of the ring, or
  /// contains the key of this request.
  std::optional<RequestFault> admit(RequestHead& head) const;
  /// True if a text is a key of the ring, or contains a text of the form of make_key. Cost: one
  /// SHA-256.
  bool is_key(std::string_view text) const;

 private:
  std::shared_ptr<const KeyRing> keys() const;

  mutable std::mutex mutex_;
  std::shared_ptr<const KeyRing> keys_;
};

}  // namespace sightline
