#pragma once
/// A setting that may change while others read it.

#include <atomic>
#include <chrono>

namespace sightline {

/// Each reader sees the old value or the new one; several settings may change one after the other.
template <class T>
class Live {
 public:
  Live(T value) : value_(value) {}
  Live(const Live& other) : value_(other.get()) {}
  Live& operator=(const Live& other) {
    value_.store(other.get(), std::memory_order_relaxed);
    return *this;
  }
  T get() const { return value_.load(std::memory_order_relaxed); }
  operator T() const { return get(); }

 private:
  std::atomic<T> value_;
};
using LiveTime = Live<std::chrono::milliseconds>;

}  // namespace sightline

// Tests: tests/unit/server/request_head_test.cpp
