#include "core/store/sha256.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <system_error>

namespace sightline {
namespace {

/// Starting a thread takes as long as the hash of so many bytes.
constexpr std::size_t kWorthAThread = 256 << 10;

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

FollowingSha256::FollowingSha256(std::span<const std::byte> bytes) : bytes_(bytes) {
  if (bytes.size() < kWorthAThread) return;
  try {
    thread_ = std::thread([this] { follow(); });
  } catch (const std::system_error&) {
    // Without a thread reach() computes the hash.
  }
}

void FollowingSha256::reach(std::size_t size) {
  if (!thread_.joinable()) hash_.update(bytes_.subspan(filled_, size - filled_));
  filled_ = size;
  told_ = 2 * size;
  told_.notify_one();
}

void FollowingSha256::follow() {
  for (std::size_t done = 0;;) {
    const std::size_t told = told_;
    if (told / 2 > done) {
      hash_.update(bytes_.subspan(done, told / 2 - done));
      done = told / 2;
    } else if (told % 2 == 1) {
      return;
    } else {
      told_.wait(told);
    }
  }
}

void FollowingSha256::end() {
  if (!thread_.joinable()) return;
  told_ = 2 * filled_ + 1;
  told_.notify_one();
  thread_.join();
}

std::string FollowingSha256::finish() {
  end();
  return hash_.finish();
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
