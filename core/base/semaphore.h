#pragma once
/// Semaphore: limits how many users there are at a time. It never waits. Permits are released by
/// their destructors.

#include <atomic>
#include <cstddef>
#include <utility>

namespace sightline {

class Semaphore;

/// One permit of a semaphore, released by the destructor; or none. True if it is a permit.
class Permit {
 public:
  Permit() = default;
  /// For Semaphore::try_acquire.
  explicit Permit(Semaphore* semaphore) : semaphore_(semaphore) {}
  Permit(Permit&& other) noexcept : semaphore_(std::exchange(other.semaphore_, nullptr)) {}
  Permit& operator=(Permit&&) = delete;
  ~Permit();
  explicit operator bool() const { return semaphore_ != nullptr; }

 private:
  Semaphore* semaphore_ = nullptr;
};

/// A number of permits. Thread-safe. Must outlive its permits.
class Semaphore {
 public:
  /// `count`: how many permits can be held at a time.
  explicit Semaphore(std::size_t count) : count_(count) {}
  /// Returns a permit, or none if `count` permits are held. Does not wait.
  Permit try_acquire() {
    if (acquired_.fetch_add(1) < count_) return Permit(this);
    --acquired_;
    return {};
  }
  std::size_t count() const { return count_; }

 private:
  friend class Permit;
  const std::size_t count_;
  std::atomic<std::size_t> acquired_{0};
};

inline Permit::~Permit() {
  if (semaphore_ != nullptr) --semaphore_->acquired_;
}

}  // namespace sightline

// Tests: tests/unit/base/semaphore_test.cpp
