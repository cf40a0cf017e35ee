#pragma once
/// SHA-256 of bytes that arrive in pieces. It names the contents of scenes.

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace sightline {

/// An incremental hash: any number of update(), then finish(). Not thread-safe.
class Sha256 {
 public:
  Sha256();
  /// Adds bytes.
  void update(std::span<const std::byte> bytes);
  /// Returns 64 lower-case hexadecimal digits; the object must not be used afterwards. Returns an
  /// empty string, which equals no hash, if the crypto library refuses to compute.
  std::string finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
  bool good_ = false;
};

/// The hash of a block of bytes, as Sha256::finish returns it.
std::string sha256_of(std::span<const std::byte> bytes);

/// True if the text has the form of a hash: 64 lower-case hexadecimal digits.
bool is_sha256(std::string_view text);

}  // namespace sightline
