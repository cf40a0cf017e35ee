#include "server/traffic_memory.h"

#include <limits>

namespace sightline {

bool TrafficMemory::has_room(const Holder* holder, std::uint64_t bytes) const {
  const std::uint64_t half = all_ / 2;
  if (bytes > std::numeric_limits<std::uint64_t>::max() - taken_) return false;
  if (taken_ + bytes <= all_) return true;
  if (large_ != nullptr && large_ != holder) return taken_ - large_->bytes_ + bytes <= half;
  return holder != nullptr && taken_ - holder->bytes_ <= half;
}

bool TrafficMemory::take(Holder* holder, std::uint64_t bytes) {
  const std::lock_guard hold(mutex_);
  if (!has_room(holder, bytes)) return false;
  taken_ += bytes;
  if (taken_ > all_ && large_ == nullptr) large_ = holder;
  if (holder != nullptr && bytes > 0) {
    if (holder->bytes_ == 0) ++holders_;
    holder->bytes_ += bytes;
  }
  return true;
}

void TrafficMemory::give(Holder* holder, std::uint64_t bytes) {
  const std::lock_guard hold(mutex_);
  taken_ -= bytes;
  if (holder != nullptr && bytes > 0) {
    holder->bytes_ -= bytes;
    if (holder->bytes_ == 0) --holders_;
  }
  if (taken_ <= all_) large_ = nullptr;
}

TrafficMemory::Waiter::Waiter(TrafficMemory& memory, const Holder& holder)
    : memory_(memory), holder_(holder) {
  const std::lock_guard hold(memory_.mutex_);
  counts_ = holder.bytes_ > 0;
  if (counts_) ++memory_.waiting_;
}

TrafficMemory::Waiter::~Waiter() {
  const std::lock_guard hold(memory_.mutex_);
  if (counts_) --memory_.waiting_;
}

bool TrafficMemory::Waiter::gives_way(std::uint64_t bytes) {
  const std::lock_guard hold(memory_.mutex_);
  if (!counts_ || memory_.waiting_ < 2 || memory_.waiting_ < memory_.holders_) return false;
  if (memory_.has_room(&holder_, bytes)) return false;
  counts_ = false;
  --memory_.waiting_;
  return true;
}

}  // namespace sightline
