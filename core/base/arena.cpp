#include "core/base/arena.h"

#include "core/base/pages.h"

namespace sightline {

Arena::Arena(std::size_t capacity) : capacity_(whole_pages(capacity)) {
  if (capacity_ > 0) data_ = static_cast<std::byte*>(take_pages(capacity_));
}

Arena::Arena(const std::byte* data, std::size_t used, std::shared_ptr<const void> owner)
    : data_(const_cast<std::byte*>(data)), used_(used), owner_(std::move(owner)) {}

Arena::~Arena() {
  if (data_ != nullptr && owner_ == nullptr) give_pages(data_, capacity_);
}

std::uint32_t Arena::take(std::size_t bytes) {
  const std::size_t start = used_;
  used_ += (bytes + kGranule - 1) / kGranule * kGranule;
  return static_cast<std::uint32_t>(start / kGranule);
}

void Arena::shrink_to_fit() {
  const std::size_t keep = whole_pages(used_);
  if (keep >= capacity_) return;
  give_pages(data_ + keep, capacity_ - keep);
  capacity_ = keep;
  if (keep == 0) data_ = nullptr;
}

}  // namespace sightline
