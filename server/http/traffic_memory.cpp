#include "server/http/traffic_memory.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace sightline {
namespace {

/// Of all, what a request has that has little; and what is kept for those.
constexpr std::uint64_t kLittleTraffic = 16, kKeptTraffic = 8;
/// How long all wait for what is sent to clients. What is sent to those who read is gone by then.
constexpr std::chrono::seconds kStandstill{1};

}  // namespace

bool TrafficMemory::has_room(const Holder* holder, std::uint64_t bytes, std::uint64_t taken) const {
  const std::uint64_t half = all_ / 2;
  if (bytes > std::numeric_limits<std::uint64_t>::max() - taken) return false;
  const bool has_little = holder != nullptr && bytes <= all_ / kLittleTraffic &&
                          holder->bytes_ + bytes <= all_ / kLittleTraffic;
  const std::uint64_t kept = has_little ? 0 : all_ / kKeptTraffic;
  if (taken + bytes <= all_ - kept) return true;
  if (large_ != nullptr && large_ != holder) return taken - large_->bytes_ + bytes <= half - kept;
  return holder != nullptr && taken - holder->bytes_ <= half;
}

bool TrafficMemory::lets_begin(const Holder& holder, std::uint64_t bytes) const {
  return holder.bytes_ > 0 || waiters_.empty() || taken_ + bytes <= all_ / 2;
}

void TrafficMemory::add(Holder* holder, std::uint64_t bytes) {
  taken_ += bytes;
  if (taken_ > all_ && large_ == nullptr) large_ = holder;
  if (holder == nullptr) {
    nobodys_ += bytes;
  } else if (bytes > 0) {
    if (holder->bytes_ == 0) ++holders_;
    holder->bytes_ += bytes;
  }
}

void TrafficMemory::subtract(Holder* holder, std::uint64_t bytes) {
  taken_ -= bytes;
  if (holder == nullptr) {
    nobodys_ -= bytes;
  } else if (bytes > 0) {
    holder->bytes_ -= bytes;
    if (holder->bytes_ == 0) --holders_;
  }
  if (taken_ <= all_) large_ = nullptr;
}

bool TrafficMemory::take(Holder* holder, std::uint64_t bytes) {
  const std::lock_guard hold(mutex_);
  if (!has_room(holder, bytes, taken_)) return false;
  add(holder, bytes);
  return true;
}

void TrafficMemory::give(Holder* holder, std::uint64_t bytes) {
  {
    const std::lock_guard hold(mutex_);
    subtract(holder, bytes);
  }
  changed_.notify_all();
}

std::uint64_t TrafficMemory::taken() const {
  const std::lock_guard hold(mutex_);
  return taken_;
}

TrafficMemory::Waiter::Waiter(TrafficMemory& memory, const Holder& holder,
                              std::function<bool(std::uint64_t)> could_go_on)
    : memory_(memory), could_go_on_(std::move(could_go_on)), counts_(holder.bytes_ > 0) {
  if (counts_) memory_.waiters_.push_back(this);
}

TrafficMemory::Waiter::~Waiter() {
  if (counts_) std::erase(memory_.waiters_, this);
}

bool TrafficMemory::Waiter::gives_way() {
  const std::vector<Waiter*>& waiters = memory_.waiters_;
  if (!counts_ || waiters.size() < 2 || waiters.size() < memory_.holders_) return false;
  const auto long_ago = std::chrono::steady_clock::now() - kStandstill;
  const bool stands = std::all_of(waiters.begin(), waiters.end(),
                                  [&](const Waiter* waiter) { return waiter->begin_ < long_ago; });
  const std::uint64_t taken = memory_.taken_ - memory_.nobodys_;
  if (!stands && std::any_of(waiters.begin(), waiters.end(),
                             [&](const Waiter* waiter) { return waiter->could_go_on_(taken); })) {
    return false;
  }
  counts_ = false;
  std::erase(memory_.waiters_, this);
  return true;
}

}  // namespace sightline
