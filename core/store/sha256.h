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

/// The hash of many bytes that arrive in pieces. From kInline bytes on, a thread of its own computes
/// it while the caller receives the next piece. Cost: the thread and 2 MiB. Not thread-safe.
class BackgroundSha256 {
 public:
  /// The first bytes are hashed by the caller: a client that sends little costs no thread.
  static constexpr std::size_t kInline = 4u << 20;

  BackgroundSha256();
  BackgroundSha256(BackgroundSha256&& other) noexcept;
  BackgroundSha256& operator=(BackgroundSha256&&) = delete;
  ~BackgroundSha256();
  /// Adds bytes, which it copies. May wait for the thread.
  void update(std::span<const std::byte> bytes);
  /// Waits for the thread, and returns what Sha256::finish returns; must be called once.
  std::string finish();

 private:
  struct Worker;  ///< the thread, and the bytes on their way to it

  Sha256 hash_;
  std::size_t size_ = 0;
  std::unique_ptr<Worker> worker_;  ///< null: the caller computes
};

/// The hash of a block of bytes, as Sha256::finish returns it.
std::string sha256_of(std::span<const std::byte> bytes);

/// True if the text has the form of a hash: 64 lower-case hexadecimal digits.
bool is_sha256(std::string_view text);

}  // namespace sightline
