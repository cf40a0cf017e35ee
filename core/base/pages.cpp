#include "core/base/pages.h"

#include <sys/mman.h>

#include <new>

namespace sightline {

std::size_t whole_pages(std::size_t bytes) {
  constexpr std::size_t kPage = 4096;
  return (bytes + kPage - 1) / kPage * kPage;
}

void* take_pages(std::size_t bytes) {
  void* const memory = mmap(nullptr, whole_pages(bytes), PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  // A wish: without huge pages everything still works.
  if (bytes >= kLargeMemory) madvise(memory, whole_pages(bytes), MADV_HUGEPAGE);
  return memory;
}

void give_pages(void* pages, std::size_t bytes) { munmap(pages, whole_pages(bytes)); }

void enlarge(OwnedPages& pages, std::size_t bytes) {
  const std::size_t size = whole_pages(bytes);
  if (pages == nullptr) {
    pages = OwnedPages(static_cast<std::byte*>(take_pages(size)), GivePages{size});
    return;
  }
  void* const memory = mremap(pages.get(), pages.get_deleter().bytes, size, MREMAP_MAYMOVE);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  static_cast<void>(pages.release());
  pages = OwnedPages(static_cast<std::byte*>(memory), GivePages{size});
  if (size >= kLargeMemory) madvise(memory, size, MADV_HUGEPAGE);
}

}  // namespace sightline
