#pragma once
/// SHA-256 of bytes that arrive in pieces: the name of a scene's content.

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace sightline {

class Sha256 {
 public:
  Sha256();
  void update(std::span<const std::byte> bytes);
  /// 64 lower-case hexadecimal digits; the object is used up. Empty if the library refused to
  /// compute, which no caller takes for a hash.
  std::string finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
  bool good_ = false;
};

std::string sha256_of(std::span<const std::byte> bytes);

/// Whether it is written as one: 64 lower-case hexadecimal digits.
bool is_sha256(std::string_view text);

}  // namespace sightline
