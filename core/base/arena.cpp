#include "core/base/arena.h"

#include <sys/mman.h>

#include <new>

namespace sightline {

namespace {
constexpr std::size_t kPage = 4096;
std::size_t whole_pages(std::size_t bytes) { return (bytes + kPage - 1) / kPage * kPage; }
}  // namespace

Arena::Arena(std::size_t capacity) : capacity_(whole_pages(capacity)) {
  if (capacity_ == 0) return;
  void* memory = mmap(nullptr, capacity_, PROT_READ | PROT_WRITE,
                      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  data_ = static_cast<std::byte*>(memory);
  // A wish: without huge pages everything still works. Small arenas stay on small pages, so that a
  // scene of ten thousand little meshes does not take 2 MiB for each.
  constexpr std::size_t kHuge = 2u << 20;
  if (capacity_ >= 4 * kHuge) madvise(data_, capacity_, MADV_HUGEPAGE);
}

Arena::Arena(const std::byte* data, std::size_t used, std::shared_ptr<const void> keeper)
    : data_(const_cast<std::byte*>(data)), used_(used), keeper_(std::move(keeper)) {}

Arena::~Arena() {
  if (data_ != nullptr && keeper_ == nullptr) munmap(data_, capacity_);
}

std::uint32_t Arena::take(std::size_t bytes) {
  const std::size_t start = used_;
  used_ += (bytes + kGranule - 1) / kGranule * kGranule;
  return static_cast<std::uint32_t>(start / kGranule);
}

void Arena::shrink_to_fit() {
  const std::size_t keep = whole_pages(used_);
  if (keep >= capacity_) return;
  munmap(data_ + keep, capacity_ - keep);
  capacity_ = keep;
  if (keep == 0) data_ = nullptr;
}

}  // namespace sightline
