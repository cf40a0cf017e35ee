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

/// The access that a request needs. kOpen: GET and HEAD of /healthz, /readyz, and of the pages and
/// documents of this program with their files. kRead: other GET, HEAD and OPTIONS, and POST to
/// routes that answer questions, DELETE of jobs. kWrite: all other requests, and POST to
/// /v1/scenes, which loads a scene.
Access needed_access(std::string_view method, std::string_view target);

/// Decides by keys which requests of a server are allowed. Thread-safe. Before the first call of
/// `use` every request is allowed.
class AccessRules {
 public:
  /// Replaces the key ring. With an empty ring, only requests that need no key (Access::kOpen) are
  /// allowed. Sets Key::revoked of each earlier key that the new ring lacks or gives less access;
  /// operations in progress under that key observe the flag.
  void use(KeyRing keys);
  /// Checks the key of a request; empty if the request is allowed. Erases the key from `head`, and
  /// sets access, key_name and revoked there. Faults: UNAUTHORIZED (401): a key is needed, and
  /// there is none or an invalid one; FORBIDDEN (403): a read key for a request that changes
  /// something. Sets hides_path and clears request_id, if they are a key of the ring or contain the
  /// key of this request.
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
