#include "server/http/work_memory.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <string>

#include "core/base/free_memory.h"

namespace sightline {
namespace {

/// How soon a waiter sees that its caller has gone.
constexpr std::chrono::milliseconds kLook{50};
/// How long a request waits until there is memory for it, where it has no deadline yet. A body waits
/// in a file, and the queue before the workers bounds how many wait.
constexpr std::chrono::milliseconds kPatience{10'000}, kBodyPatience{600'000};
constexpr std::uint64_t kFree = 256 << 10;
/// From here on pages that are fresh again cost little beside the rest of the request.
constexpr std::uint64_t kLarge = 16 << 20;
/// Of all memory, what is kept for little shares.
constexpr std::uint64_t kKeptWork = 8;

std::uint64_t beyond_free(std::uint64_t bytes) { return bytes - std::min(bytes, kFree); }

std::uint64_t sum(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  return a > kMost - b ? kMost : a + b;
}

}  // namespace

bool WorkMemory::Share::is_within(std::uint64_t size, std::uint64_t others) const {
  const std::uint64_t all = memory_.all_;
  return sum(others, size) <= (size <= memory_.little() ? all : all - all / kKeptWork);
}

bool WorkMemory::Share::fits(std::uint64_t bytes, std::uint64_t traffic_taken) const {
  const bool is_alone = memory_.beyond_ == this || memory_.beyond_ == nullptr;
  return (is_alone || is_within(sum(bytes_, bytes), memory_.taken_ - bytes_)) &&
         memory_.traffic_.has_room(&holder_, bytes, traffic_taken);
}

bool WorkMemory::Share::try_grow(std::uint64_t bytes, bool stays_little) {
  WorkMemory& memory = memory_;
  TrafficMemory& traffic = memory.traffic_;
  if (!fits(bytes, traffic.taken_)) return false;
  if (memory.begins_late_ && !stays_little && !traffic.lets_begin(holder_, bytes)) return false;
  traffic.add(&holder_, bytes);
  if (memory.beyond_ != this && is_within(bytes_ + bytes, memory.taken_ - bytes_)) {
    memory.taken_ += bytes;
  } else if (memory.beyond_ != this) {
    memory.beyond_ = this;
    memory.taken_ -= bytes_;
  }
  bytes_ += bytes;
  return true;
}

Status WorkMemory::Share::wait(std::uint64_t bytes, const Deadline& deadline, bool stays_little) {
  if (sum(bytes_, bytes) > memory_.one_) {
    return Error{ErrorKind::kTooLarge, "REQUEST_TOO_LARGE",
                 "this request would take some " + std::to_string(sum(bytes_, bytes)) +
                     " bytes of memory, and one request may take " + std::to_string(memory_.one_) +
                     ": ask for less at once",
                 ""};
  }
  const auto busy = [] {
    return Error{ErrorKind::kBusy, "MEMORY_BUSY",
                 "large requests use all the memory that they may: ask again later", ""};
  };
  TrafficMemory& traffic = memory_.traffic_;
  std::unique_lock hold(traffic.mutex_);
  // Requests begin in the order in which they come, except small ones.
  std::deque<const Share*>& queue = memory_.queue_;
  const bool queues = memory_.begins_late_ && !stays_little && bytes_ == 0;
  if ((!queues || queue.empty()) && try_grow(bytes, stays_little)) return success();
  if (deadline.passed()) return busy();
  if (queues) queue.push_back(this);
  TrafficMemory::Waiter waiter(traffic, holder_,
                               [&](std::uint64_t taken) { return fits(bytes, taken); });
  ++memory_.waiting_;
  bool has_grown = false;
  while (!has_grown && !deadline.passed() && !waiter.gives_way()) {
    traffic.changed_.wait_for(hold, kLook);
    has_grown = (!queues || queue.front() == this) && try_grow(bytes, stays_little);
  }
  --memory_.waiting_;
  if (queues) {
    std::erase(queue, this);
    // The next one may begin as well.
    traffic.changed_.notify_all();
  }
  if (!has_grown) return busy();
  return success();
}

void WorkMemory::Share::keep(std::uint64_t bytes, std::uint64_t beside) {
  const std::uint64_t before = bytes_ + beside_;
  bytes = std::min(bytes, bytes_);
  beside = std::min(beside, before - bytes);
  if (bytes == bytes_ && beside == beside_) return;
  TrafficMemory& traffic = memory_.traffic_;
  {
    const std::lock_guard hold(traffic.mutex_);
    if (memory_.beyond_ != this) {
      memory_.taken_ -= bytes_ - bytes;
    } else if (bytes == 0 || is_within(bytes, memory_.taken_)) {
      memory_.beyond_ = nullptr;
      memory_.taken_ += bytes;
    }
    traffic.subtract(&holder_, before - bytes - beside);
    bytes_ = bytes;
    beside_ = beside;
  }
  traffic.changed_.notify_all();
}

RequestMemory::~RequestMemory() {
  if (most_ >= kLarge) give_back_free_memory();
}

Status RequestMemory::reserve(std::uint64_t bytes) {
  const std::uint64_t after = sum(bytes_, bytes);
  const std::uint64_t more = beyond_free(after) - beyond_free(bytes_);
  if (more > 0) {
    if (at_door_) {
      return Error{ErrorKind::kBusy, "MEMORY_BUSY", "a worker has to answer this", ""};
    }
    Status status = work_.grow(more);
    if (!status && status.error().kind == ErrorKind::kBusy) {
      const Claim place = waiters_ == nullptr ? Claim() : waiters_->claim();
      was_refused_ = waiters_ != nullptr && !place;
      if (was_refused_) return status;
      Deadline deadline = Deadline::in(kPatience, caller_);
      if (until_ != Deadline::Clock::time_point::max()) deadline.at = until_;
      status = work_.wait(more, deadline);
      if (!status && deadline.at == until_ && deadline.passed()) return out_of_time(deadline);
    }
    was_refused_ = !status && status.error().kind == ErrorKind::kBusy;
    if (!status) return status;
  }
  bytes_ = after;
  // What others have freed must not stand beside it.
  if (most_ < kLarge && bytes_ >= kLarge) give_back_free_memory();
  most_ = std::max(most_, bytes_);
  return success();
}

Status RequestMemory::reserve_body(std::uint64_t bytes, bool stays_little) {
  Status status = body_.wait(bytes, Deadline::in(kBodyPatience, caller_), stays_little);
  was_refused_ = !status && status.error().kind == ErrorKind::kBusy;
  return status;
}

void RequestMemory::keep(std::uint64_t bytes) {
  bytes_ = std::min(bytes_, bytes);
  work_.keep(beyond_free(bytes_));
}

void RequestMemory::keep_while_streaming(std::uint64_t bytes) {
  bytes = std::min(bytes, bytes_);
  bytes_ = std::min(bytes, memory_.little());
  work_.keep(beyond_free(bytes_), beyond_free(bytes) - beyond_free(bytes_));
}

bool RequestMemory::is_little(std::uint64_t bytes) const {
  return beyond_free(bytes) <= memory_.little();
}

bool RequestMemory::keeps_others_waiting() const {
  return !is_little(bytes_) && memory_.is_wanted();
}

bool RequestMemory::body_keeps_others_waiting() const {
  // Even if all who read bodies had so much, half would be left.
  constexpr std::uint64_t kPart = 64;
  return body_.bytes() > bodies_.all() / kPart && (bodies_.is_wanted() || memory_.is_wanted());
}

}  // namespace sightline
