#include "server/access/key_ring.h"

#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <span>

#include "core/store/posix_file.h"
#include "core/store/scene_id.h"
#include "core/store/sha256.h"

namespace sightline {
namespace {

constexpr std::string_view kPrefix = "slk_", kHash = "sha256:";
constexpr std::string_view kAlphabet =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
/// Nobody has more, and each is compared for each request.
constexpr std::size_t kMostKeys = 1000, kMostBytes = 1 << 20;
constexpr std::size_t kLongestKey = 512;
constexpr std::size_t kDigits = 64;

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (;;) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
    if (line.empty()) return words;
    const std::size_t end = std::min(line.find_first_of(" \t\r"), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

/// What is wrong with a line, or nothing.
const char* read_key(const std::vector<std::string_view>& words, Key& key) {
  if (words.size() != 3) return "a line has a role, a name and a hash";
  if (words[0] != "read" && words[0] != "write") return "the role is neither read nor write";
  if (!is_key_name(words[1])) {
    return "a name has 1 to 128 of the characters A-Z a-z 0-9 . _ -, and begins with no dot";
  }
  if (!words[2].starts_with(kHash) || !is_sha256(words[2].substr(kHash.size()))) {
    return "the hash is not sha256: and 64 lower-case hexadecimal digits";
  }
  key.access = words[0] == "write" ? Access::kWrite : Access::kRead;
  key.name = words[1];
  key.sha256 = words[2].substr(kHash.size());
  return nullptr;
}

}  // namespace

std::string_view access_name(Access access) {
  switch (access) {
    case Access::kOpen:
      return "open";
    case Access::kRead:
      return "read";
    case Access::kWrite:
      return "write";
  }
  return "open";
}

Result<KeyRing> KeyRing::parse(std::string_view text) {
  KeyRing ring;
  std::size_t number = 0;
  const auto fault = [&](const char* what) {
    return Error{ErrorKind::kInvalid, "KEYS_INVALID",
                 "line " + std::to_string(number) + " of the keys: " + what, ""};
  };
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const auto words = words_of(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    ++number;
    if (words.empty() || words[0].front() == '#') continue;
    Key key;
    if (const char* wrong = read_key(words, key)) return fault(wrong);
    for (const Key& other : ring.keys_) {
      if (other.name == key.name) return fault("an earlier line has the same name");
      if (other.sha256 == key.sha256) return fault("an earlier line has the same key");
    }
    if (ring.keys_.size() == kMostKeys) return fault("there are more than 1000 keys");
    ring.keys_.push_back(std::move(key));
  }
  return ring;
}

Result<KeyRing> KeyRing::read(const std::filesystem::path& file,
                              std::vector<std::string>& warnings) {
  struct stat status {};
  const bool found = ::stat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode);
  const auto text =
      found ? read_small_file(file, kMostBytes, "read the keys")
            : Error{ErrorKind::kNotFound, "", "cannot read the keys: it is no file", ""};
  if (!text) {
    return Error{ErrorKind::kNotFound, "KEYS_UNREADABLE", text.error().message, ""};
  }
  if ((status.st_mode & S_IROTH) != 0) {
    warnings.emplace_back("others can read the file of --keys: chmod o-r");
  }
  if ((status.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    warnings.emplace_back("others can write to the file of --keys: chmod go-w");
  }
  auto ring = parse(*text);
  if (ring && ring->size() == 0) {
    warnings.emplace_back("the file of --keys has no key: nobody may ask anything");
  }
  return ring;
}

const Key* KeyRing::find(std::string_view key) const {
  const std::string hash = key_sha256(key.substr(0, kLongestKey));
  const Key* found = nullptr;
  for (const Key& each : keys_) {
    const bool same =
        hash.size() == kDigits && CRYPTO_memcmp(hash.data(), each.sha256.data(), kDigits) == 0;
    if (same) found = &each;
  }
  return key.empty() || key.size() > kLongestKey ? nullptr : found;
}

void KeyRing::succeed(const KeyRing& before) {
  for (const Key& old : before.keys_) {
    const auto same = std::find_if(keys_.begin(), keys_.end(), [&](const Key& key) {
      return key.sha256 == old.sha256 && key.access >= old.access;
    });
    if (same == keys_.end()) {
      old.revoked->cancel();
    } else {
      same->revoked = old.revoked;
    }
  }
}

bool is_key_name(std::string_view text) { return is_scene_id(text) && !holds_key(text); }

std::string key_line(const Key& key) {
  return std::string(access_name(key.access)) + " " + key.name + " " + std::string(kHash) +
         key.sha256;
}

Result<std::string> make_key() {
  std::array<unsigned char, 32> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) {
    return Error{ErrorKind::kInternal, "KEY_NOT_MADE", "the system has no random bytes", ""};
  }
  std::string key(kPrefix);
  unsigned held = 0;
  int bits = 0;
  for (const unsigned char byte : bytes) {
    held = held << 8 | byte;
    for (bits += 8; bits >= 6; bits -= 6) key += kAlphabet[held >> (bits - 6) & 63u];
  }
  return key + kAlphabet[held << (6 - bits) & 63u];
}

std::string key_sha256(std::string_view key) {
  return sha256_of(std::as_bytes(std::span(key.data(), key.size())));
}

bool holds_key(std::string_view text) {
  // A key that was cut short is no secret any more that is worth showing.
  constexpr std::size_t kTelling = 20;
  for (std::size_t at = text.find(kPrefix); at != std::string_view::npos;
       at = text.find(kPrefix, at + 1)) {
    const std::string_view rest = text.substr(at + kPrefix.size());
    if (std::min(rest.find_first_not_of(kAlphabet), rest.size()) >= kTelling) return true;
  }
  return false;
}

}  // namespace sightline
