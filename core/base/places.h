#pragma once
/// A number of places that are taken and given back.

#include <atomic>
#include <cstddef>
#include <utility>

namespace sightline {

class Places;

/// One place, given back with this object; or none.
class Claim {
 public:
  Claim() = default;
  explicit Claim(Places* places) : places_(places) {}
  Claim(Claim&& other) noexcept : places_(std::exchange(other.places_, nullptr)) {}
  Claim& operator=(Claim&&) = delete;
  ~Claim();
  explicit operator bool() const { return places_ != nullptr; }

 private:
  Places* places_ = nullptr;
};

/// May be used from many threads; outlives its claims.
class Places {
 public:
  explicit Places(std::size_t count) : count_(count) {}
  /// Nothing when all are taken.
  Claim claim() {
    if (taken_.fetch_add(1) < count_) return Claim(this);
    --taken_;
    return {};
  }
  std::size_t count() const { return count_; }

 private:
  friend class Claim;
  const std::size_t count_;
  std::atomic<std::size_t> taken_{0};
};

inline Claim::~Claim() {
  if (places_ != nullptr) --places_->taken_;
}

}  // namespace sightline

// Tests: tests/unit/server/request_memory_test.cpp
