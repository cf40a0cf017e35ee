#include "server/http/request_memory.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <string>

#include "core/base/free_memory.h"

namespace sightline {
namespace {

/// How soon a waiting request sees that its client has gone.
constexpr std::chrono::milliseconds kTick{50};
/// How long a request waits that has no deadline yet. Its body is in a file, and the queue before the
/// workers bounds how many wait.
constexpr std::chrono::minutes kPatience{10};
constexpr std::chrono::seconds kStreamPatience{10};
constexpr std::uint64_t kFree = 256 << 10;
/// Smaller requests leave no memory that is worth returning. A stream counts once, at its end, with
/// its largest batch. Where only 4 MiB and more counted, 128 streams left 60 MiB with the allocator.
constexpr std::uint64_t kLarge = 1 << 20;
/// Returned after each request of 10,000 rays, memory took a third of the request: its pages are
/// fresh again. Returned after 32 MiB, it takes some 1% of the request.
constexpr std::uint64_t kMostFreed = 32 << 20;

std::uint64_t beyond_free(std::uint64_t bytes) { return bytes - std::min(bytes, kFree); }

std::uint64_t sum(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  return a > kMost - b ? kMost : a + b;
}

}  // namespace

bool MemoryBudget::charge(std::uint64_t bytes, std::uint64_t part) {
  const std::lock_guard hold(mutex_);
  // The last eighth is for small requests here too.
  if (sum(charged_, bytes) > all_ / part || sum(taken_, bytes) > all_ - all_ / 8) return false;
  charged_ += bytes;
  taken_ += bytes;
  return true;
}

void MemoryBudget::release(std::uint64_t bytes) {
  if (bytes == 0) return;
  {
    const std::lock_guard hold(mutex_);
    charged_ -= bytes;
    taken_ -= bytes;
    if (taken_ <= all_) large_ = nullptr;
  }
  changed_.notify_all();
}

bool MemoryBudget::has_room(const Holder& holder, std::uint64_t bytes) const {
  if (bytes > std::numeric_limits<std::uint64_t>::max() - taken_) return false;
  const std::uint64_t kept = is_small(sum(holder.bytes, bytes)) ? 0 : all_ / 8;
  if (taken_ + bytes <= all_ - kept) return true;
  if (large_ != nullptr && large_ != &holder) {
    return taken_ - large_->bytes + bytes <= all_ / 2 - kept;
  }
  return taken_ - holder.bytes <= all_ / 2;
}

bool MemoryBudget::may_overtake(const Holder& holder, std::uint64_t bytes) const {
  // What stays within half of the budget delays no waiting request: each may begin beside that half.
  const std::uint64_t others = taken_ - (large_ == nullptr ? 0 : large_->bytes);
  return is_small(sum(holder.bytes, bytes)) || sum(others, bytes) <= all_ / 2 - all_ / 8;
}

bool MemoryBudget::try_take(Holder& holder, std::uint64_t bytes) {
  if (!has_room(holder, bytes)) return false;
  taken_ += bytes;
  holder.bytes += bytes;
  if (taken_ > all_ && large_ == nullptr) large_ = &holder;
  return true;
}

bool MemoryBudget::take(Holder& holder, std::uint64_t bytes) {
  const std::lock_guard hold(mutex_);
  const bool waits = !queue_.empty() && holder.bytes == 0 && !may_overtake(holder, bytes);
  return !waits && try_take(holder, bytes);
}

bool MemoryBudget::wait(Holder& holder, std::uint64_t bytes, const Deadline& deadline) {
  std::unique_lock hold(mutex_);
  queue_.push_back(&holder);
  bool has_taken = false;
  while (!has_taken && !deadline.passed()) {
    const bool is_next = queue_.front() == &holder || may_overtake(holder, bytes);
    has_taken = is_next && try_take(holder, bytes);
    if (!has_taken) changed_.wait_for(hold, kTick);
  }
  std::erase(queue_, &holder);
  hold.unlock();
  // The next one may begin as well.
  changed_.notify_all();
  return has_taken;
}

void MemoryBudget::keep(Holder& holder, std::uint64_t bytes) {
  if (holder.bytes <= bytes) return;
  {
    const std::lock_guard hold(mutex_);
    taken_ -= holder.bytes - bytes;
    holder.bytes = bytes;
    if (taken_ <= all_) large_ = nullptr;
  }
  changed_.notify_all();
}

std::uint64_t MemoryBudget::taken() const {
  const std::lock_guard hold(mutex_);
  return taken_;
}

bool MemoryBudget::is_wanted(std::uint64_t bytes) const {
  // So small a request is left alone: 32 of them hold half of the memory.
  if (bytes <= all_ / 64) return false;
  const std::lock_guard hold(mutex_);
  return !queue_.empty();
}

bool MemoryBudget::count_freed(std::uint64_t bytes) {
  const std::lock_guard hold(mutex_);
  freed_ = sum(freed_, bytes);
  if (freed_ < kMostFreed && sum(taken_, freed_) <= all_ / 4) return false;
  freed_ = 0;
  return true;
}

RequestMemory::~RequestMemory() {
  budget_.keep(holder_, 0);
  if (most_ >= kLarge && budget_.count_freed(most_)) give_back_free_memory();
}

Status RequestMemory::grow(std::uint64_t held) {
  if (held > budget_.one()) {
    return Error{ErrorKind::kTooLarge, "REQUEST_TOO_LARGE",
                 "this request would take some " + std::to_string(held) +
                     " bytes of memory, and one request may take " + std::to_string(budget_.one()) +
                     ": ask for less at once",
                 ""};
  }
  const Error busy{ErrorKind::kBusy, "MEMORY_BUSY",
                   "other requests use all the memory that they may: ask again later", ""};
  if (wait_ == Wait::kNever) return busy;
  planned_ = std::max(planned_, std::min(plan_.bytes, budget_.one()));
  const std::uint64_t more = std::max(held, planned_) - holder_.bytes;
  if (budget_.take(holder_, more)) return success();
  if (wait_ == Wait::kStream || (wait_ == Wait::kWhileEmpty && holder_.bytes == 0)) {
    Deadline deadline = wait_ == Wait::kStream ? Deadline::in(kStreamPatience, caller_)
                                               : Deadline::in(kPatience, caller_);
    const auto until = std::min(until_, plan_.until);
    const bool may_take_long = until != Deadline::Clock::time_point::max();
    if (may_take_long) deadline.at = until;
    if (budget_.wait(holder_, more, deadline)) return success();
    if (may_take_long && deadline.passed()) return out_of_time(deadline);
  }
  was_refused_ = true;
  plan_ = {std::max(plan_.bytes, held), std::min(plan_.until, until_)};
  return busy;
}

Status RequestMemory::reserve(std::uint64_t bytes) {
  const std::uint64_t used = sum(used_, bytes), held = beyond_free(sum(used, pinned_));
  was_refused_ = false;
  if (held > holder_.bytes) {
    if (Status status = grow(held); !status) return status;
  }
  used_ = used;
  // Under pressure, what others have freed must not stand beside it.
  if (most_ < kLarge && used_ >= kLarge && budget_.count_freed(0)) give_back_free_memory();
  most_ = std::max(most_, used_);
  return success();
}

Status RequestMemory::pin(std::uint64_t bytes) {
  Status status = reserve(bytes);
  if (!status) return status;
  used_ -= bytes;
  pinned_ += bytes;
  return status;
}

void RequestMemory::keep(std::uint64_t bytes) {
  used_ = std::min(used_, bytes);
  budget_.keep(holder_, std::max(beyond_free(used_ + pinned_), planned_));
}

void RequestMemory::finish(std::uint64_t bytes) {
  planned_ = 0;
  keep(bytes);
}

}  // namespace sightline
