#pragma once
/// Keys that clients show: what a file stores of them, and which one a client has.

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "server/http/request_head.h"

namespace sightline {

std::string_view access_name(Access access);

struct Key {
  std::string name;  ///< for logs; as a scene's name
  Access access = Access::kRead;
  std::string sha256;  ///< of the key, 64 lower-case hexadecimal digits
  /// Set when a later ring has it no more, or allows it less: for what goes on under it.
  std::shared_ptr<CancelFlag> revoked = std::make_shared<CancelFlag>();
};

class KeyRing {
 public:
  /// One key in each line, as key_line() writes it; empty lines and such that begin with # say
  /// nothing. Errors: KEYS_INVALID with the line's number and nothing of what stands there: it
  /// might be a key. Names and keys differ from each other.
  static Result<KeyRing> parse(std::string_view text);
  /// Reads the keys of a file. `warnings` lists what is wrong with its permissions. Errors: also
  /// KEYS_UNREADABLE.
  static Result<KeyRing> read(const std::filesystem::path& file,
                              std::vector<std::string>& warnings);

  /// Null for a key that is none. Takes the same time for each: SHA-256 hides where two differ, and
  /// all are compared.
  const Key* find(std::string_view key) const;
  std::size_t size() const { return keys_.size(); }
  /// Comes instead of `before`: what goes on under its keys may, where they are here as well.
  void succeed(const KeyRing& before);

 private:
  std::vector<Key> keys_;
};

/// 1 to 128 of A-Z a-z 0-9 . _ -, not beginning with a dot, and no key itself.
bool is_key_name(std::string_view text);
/// "write ci sha256:9f86d0..."
std::string key_line(const Key& key);
/// A fresh key of 256 random bits: "slk_" and 43 characters of base64url. KEY_NOT_MADE: the system
/// has no random bytes.
Result<std::string> make_key();
std::string key_sha256(std::string_view key);

/// Whether somewhere in a text stands what make_key makes, or most of it: such a text is not shown.
bool holds_key(std::string_view text);

}  // namespace sightline
