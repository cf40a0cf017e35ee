#include "server/work_memory.h"

#include <algorithm>

namespace sightline {
namespace {

/// How soon a waiter sees that its caller has gone.
constexpr std::chrono::milliseconds kLook{50};

}  // namespace

WorkMemory::Share::~Share() {
  {
    const std::lock_guard hold(memory_.mutex_);
    memory_.taken_ -= bytes_;
  }
  memory_.changed_.notify_all();
}

bool WorkMemory::Share::grow(std::uint64_t bytes) {
  const std::lock_guard hold(memory_.mutex_);
  if (!memory_.fits(bytes, bytes_)) return false;
  memory_.taken_ += bytes;
  bytes_ += bytes;
  return true;
}

bool WorkMemory::Share::wait(std::uint64_t bytes, const Deadline& deadline) {
  std::unique_lock hold(memory_.mutex_);
  while (!memory_.fits(bytes, bytes_)) {
    if (deadline.passed()) return false;
    memory_.changed_.wait_for(hold, kLook);
  }
  memory_.taken_ += bytes;
  bytes_ += bytes;
  return true;
}

}  // namespace sightline
