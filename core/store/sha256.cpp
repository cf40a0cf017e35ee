#include "core/store/sha256.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <exception>
#include <semaphore>
#include <thread>
#include <utility>

#include "core/base/column.h"

namespace sightline {
namespace {

/// As long as the pieces of a file that is read by path: in shorter buffers its reader waits for the
/// thread several times for each piece, and a large file takes a fifth longer.
constexpr std::size_t kBuffer = 1u << 20;

}  // namespace

void Sha256::Free::operator()(evp_md_ctx_st* context) const { EVP_MD_CTX_free(context); }

Sha256::Sha256() : context_(EVP_MD_CTX_new()) {
  good_ = context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1;
}

void Sha256::update(std::span<const std::byte> bytes) {
  good_ = good_ && EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) == 1;
}

std::string Sha256::finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  good_ = good_ && EVP_DigestFinal_ex(context_.get(), digest.data(), &size) == 1;
  if (!good_) return {};
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (unsigned i = 0; i < size; ++i) {
    text += kDigits[digest[i] >> 4];
    text += kDigits[digest[i] & 15u];
  }
  return text;
}

/// One buffer is filled while the thread reads the other.
struct BackgroundSha256::Worker {
  Worker() : read_(kBuffer), filled_(kBuffer), thread_([this] { run(); }) {}
  ~Worker() { stop(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  void update(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const auto part = bytes.first(std::min(bytes.size(), kBuffer - size_));
      std::copy(part.begin(), part.end(), filled_.data() + size_);
      size_ += part.size();
      bytes = bytes.subspan(part.size());
      if (size_ == kBuffer) hand_over();
    }
  }
  /// Hands over the rest and ends the thread.
  void stop() {
    if (!thread_.joinable()) return;
    if (size_ > 0) hand_over();
    hand_over();  // nothing: the end
    thread_.join();
  }

  Sha256 hash;  ///< to be set before update(), and read after stop()

 private:
  /// Waits until the thread has read its buffer, and gives it the filled one.
  void hand_over() {
    taken_.acquire();
    std::swap(read_, filled_);
    read_size_ = std::exchange(size_, 0);
    handed_.release();
  }
  void run() {
    for (handed_.acquire(); read_size_ > 0; handed_.acquire()) {
      hash.update(std::span(read_).first(read_size_));
      taken_.release();
    }
  }

  UnsetColumn<std::byte> read_, filled_;
  std::size_t read_size_ = 0, size_ = 0;  ///< bytes in read_ and in filled_
  std::binary_semaphore handed_{0}, taken_{1};
  std::thread thread_;  ///< after all that it uses
};

BackgroundSha256::BackgroundSha256() = default;
BackgroundSha256::BackgroundSha256(BackgroundSha256&& other) noexcept = default;
BackgroundSha256::~BackgroundSha256() = default;

void BackgroundSha256::update(std::span<const std::byte> bytes) {
  if (worker_) return worker_->update(bytes);
  hash_.update(bytes);
  size_ += bytes.size();
  if (size_ < kInline) return;
  size_ = 0;
  try {
    worker_ = std::make_unique<Worker>();
    worker_->hash = std::move(hash_);
  } catch (const std::exception&) {
    // Without a thread or memory for it the caller computes, and tries again later.
  }
}

std::string BackgroundSha256::finish() {
  if (!worker_) return hash_.finish();
  worker_->stop();
  return worker_->hash.finish();
}

std::string sha256_of(std::span<const std::byte> bytes) {
  Sha256 hash;
  hash.update(bytes);
  return hash.finish();
}

bool is_sha256(std::string_view text) {
  return text.size() == 64 && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

}  // namespace sightline
