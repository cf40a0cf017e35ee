#pragma once
/// Live<T>: a setting that one thread changes while others read it.

#include <atomic>
#include <chrono>

namespace sightline {

/// An atomic value with relaxed order. A reader gets the old value or the new one. Several settings
/// that are set in turn may be seen in any order. A copy has the value at the time of the copy.
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
/// A duration that may change, in milliseconds.
using LiveTime = Live<std::chrono::milliseconds>;

}  // namespace sightline

// Tests: tests/unit/server/request_head_test.cpp
