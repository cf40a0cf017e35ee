#pragma once
/// SHA-256 of bytes that arrive in pieces. It names the contents of scenes.

#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <thread>

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

/// The hash of memory that its user fills from the front. A thread of its own follows in large
/// memory. Not thread-safe.
class FollowingSha256 {
 public:
  /// `bytes` must stay valid as long as this object.
  explicit FollowingSha256(std::span<const std::byte> bytes);
  FollowingSha256(const FollowingSha256&) = delete;
  FollowingSha256& operator=(const FollowingSha256&) = delete;
  ~FollowingSha256() { end(); }
  /// Tells that the first `size` bytes are filled. Precondition: not fewer than before.
  void reach(std::size_t size);
  /// Waits, and returns the hash of the bytes that were filled, as Sha256::finish.
  std::string finish();

 private:
  void follow();
  void end();

  const std::span<const std::byte> bytes_;
  Sha256 hash_;
  std::size_t filled_ = 0;
  std::atomic<std::size_t> told_{0};  ///< 2 * filled_, and 1 more at the end
  std::thread thread_;
};

/// The hash of a block of bytes, as Sha256::finish returns it.
std::string sha256_of(std::span<const std::byte> bytes);

/// True if the text has the form of a hash: 64 lower-case hexadecimal digits.
bool is_sha256(std::string_view text);

}  // namespace sightline
