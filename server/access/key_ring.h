#pragma once
/// KeyRing: the keys that clients may use. A file stores their hashes.

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "server/http/request_head.h"

namespace sightline {

/// "open", "read" or "write".
std::string_view access_name(Access access);

/// An entry of a key ring, without the key itself.
struct Key {
  std::string name;  ///< for logs; has the form of a scene's name
  Access access = Access::kRead;
  std::string sha256;  ///< hash of the key, 64 lower-case hexadecimal digits
  /// Set when a later ring no longer has the key, or gives it less access. Operations in progress
  /// under the key observe it.
  std::shared_ptr<CancelFlag> revoked = std::make_shared<CancelFlag>();
};

/// The keys of a file: at most 1000. Immutable, except for the flags `revoked`, which succeed()
/// sets.
class KeyRing {
 public:
  /// Parses lines of the form of key_line. Empty lines and lines that begin with # are ignored.
  /// Names and keys must be unique. Errors: KEYS_INVALID with the number of the line. The message
  /// does not contain its text, which might be a key.
  static Result<KeyRing> parse(std::string_view text);
  /// Reads the keys of a file of at most 1 MiB. Appends to `warnings`: unsafe permissions, or no
  /// key in the file. Errors: those of parse, KEYS_UNREADABLE.
  static Result<KeyRing> read(const std::filesystem::path& file,
                              std::vector<std::string>& warnings);

  /// The entry of a key, valid while the ring lives; null if it is not in the ring. The hash is
  /// compared with that of every entry, in a time that does not depend on the key.
  const Key* find(std::string_view key) const;
  std::size_t size() const { return keys_.size(); }
  /// Takes over from `before`. A key that is in both rings, with no less access here, shares its
  /// flag `revoked`, so that operations in progress may continue. The flags of other keys are set.
  void succeed(const KeyRing& before);

 private:
  std::vector<Key> keys_;
};

/// True for 1 to 128 characters of A-Z a-z 0-9 . _ - that do not begin with a dot and do not
/// contain a key.
bool is_key_name(std::string_view text);
/// The line of a key in a file: "write ci sha256:9f86d0...".
std::string key_line(const Key& key);
/// Makes a key of 256 random bits: "slk_" and 43 characters of base64url. Errors: KEY_NOT_MADE if
/// the system has no random bytes.
Result<std::string> make_key();
/// The hash of a key, 64 lower-case hexadecimal digits.
std::string key_sha256(std::string_view key);

/// True if a text contains "slk_" and at least 20 characters of base64url. Such a text is not
/// logged.
bool holds_key(std::string_view text);

}  // namespace sightline
