#include "server/work_memory.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <string>

#include "core/store/free_memory.h"

namespace sightline {
namespace {

/// How soon a waiter sees that its caller has gone.
constexpr std::chrono::milliseconds kLook{50};
/// How long a request waits until there is memory for it.
constexpr std::chrono::milliseconds kPatience{10'000};
constexpr std::uint64_t kFree = 256 << 10;
/// From here on pages that are fresh again cost little beside the rest of the request.
constexpr std::uint64_t kLarge = 16 << 20;
/// Of all memory, what nobody is blamed for holding.
constexpr std::uint64_t kLittlePart = 16;

std::uint64_t beyond_free(std::uint64_t bytes) { return bytes - std::min(bytes, kFree); }

std::uint64_t sum(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  return a > kMost - b ? kMost : a + b;
}

}  // namespace

bool WorkMemory::Share::try_grow(std::uint64_t bytes) {
  WorkMemory& memory = memory_;
  if (memory.beyond_ != this) {
    const std::uint64_t after = sum(memory.taken_, bytes);
    if (after <= memory.all_) {
      memory.taken_ = after;
    } else if (memory.beyond_ == nullptr) {
      memory.beyond_ = this;
      memory.taken_ -= bytes_;
    } else {
      return false;
    }
  }
  bytes_ += bytes;
  return true;
}

Status WorkMemory::Share::wait(std::uint64_t bytes, const Deadline& deadline) {
  if (sum(bytes_, bytes) > memory_.one_) {
    return Error{ErrorKind::kTooLarge, "REQUEST_TOO_LARGE",
                 "this request would take some " + std::to_string(sum(bytes_, bytes)) +
                     " bytes of memory, and one request may take " + std::to_string(memory_.one_) +
                     ": ask for less at once",
                 ""};
  }
  std::unique_lock hold(memory_.mutex_);
  if (try_grow(bytes)) return success();
  ++memory_.waiting_;
  const auto done = [this](Status status) {
    --memory_.waiting_;
    return status;
  };
  while (!try_grow(bytes)) {
    if (deadline.passed()) {
      return done(Error{ErrorKind::kBusy, "MEMORY_BUSY",
                        "large requests use all the memory that they may: ask again later", ""});
    }
    memory_.changed_.wait_for(hold, kLook);
  }
  return done(success());
}

void WorkMemory::Share::keep(std::uint64_t bytes) {
  if (bytes_ <= bytes) return;
  {
    const std::lock_guard hold(memory_.mutex_);
    if (memory_.beyond_ != this) {
      memory_.taken_ -= bytes_ - bytes;
    } else if (bytes == 0 || sum(memory_.taken_, bytes) <= memory_.all_) {
      memory_.beyond_ = nullptr;
      memory_.taken_ += bytes;
    }
    bytes_ = bytes;
  }
  memory_.changed_.notify_all();
}

RequestMemory::~RequestMemory() {
  if (most_ >= kLarge) give_back_free_memory();
}

Status RequestMemory::reserve(std::uint64_t bytes) {
  const std::uint64_t after = sum(bytes_, bytes);
  const std::uint64_t more = beyond_free(after) - beyond_free(bytes_);
  if (more > 0) {
    Status status = work_.grow(more);
    if (!status && status.error().kind == ErrorKind::kBusy) {
      const Claim place = waiters_ == nullptr ? Claim() : waiters_->claim();
      if (waiters_ != nullptr && !place) return status;
      status = work_.wait(more, Deadline::in(kPatience, caller_));
    }
    if (!status) return status;
  }
  bytes_ = after;
  most_ = std::max(most_, bytes_);
  return success();
}

void RequestMemory::keep(std::uint64_t bytes) {
  bytes_ = std::min(bytes_, bytes);
  work_.keep(beyond_free(bytes_));
}

void RequestMemory::keep_while_streaming(std::uint64_t bytes) {
  keep(std::min(bytes, memory_.all() / kLittlePart));
}

bool RequestMemory::keeps_others_waiting() const {
  return beyond_free(bytes_) > memory_.all() / kLittlePart && memory_.is_wanted();
}

}  // namespace sightline
