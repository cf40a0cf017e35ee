#pragma once
/// Large memory directly from the system (mmap). Its pages take no memory before they are written,
/// and all of them return to the system when they are freed.

#include <cstddef>
#include <memory>

namespace sightline {

/// Allocations below this size, in bytes, should come from the allocator. take_pages uses no huge
/// pages for them, so that ten thousand small meshes do not take 2 MiB each.
inline constexpr std::size_t kLargeMemory = 8u << 20;

/// `bytes` rounded up to whole pages.
std::size_t whole_pages(std::size_t bytes);
/// Allocates `bytes` of zeros, rounded up to whole pages; on huge pages where the system has them
/// and bytes >= kLargeMemory. The caller frees them by give_pages. Throws std::bad_alloc.
void* take_pages(std::size_t bytes);
/// Unmaps [pages, pages + bytes). Precondition: it is an allocation of take_pages, or a part of one
/// that begins at a page.
void give_pages(void* pages, std::size_t bytes);

/// Frees an allocation of take_pages.
struct GivePages {
  std::size_t bytes = 0;  ///< its size
  void operator()(std::byte* pages) const { give_pages(pages, bytes); }
};
/// Owns an allocation of take_pages.
using OwnedPages = std::unique_ptr<std::byte, GivePages>;
/// Enlarges an allocation, which may be null, to `bytes` rounded up to whole pages. The content
/// remains, followed by zeros. Pages are remapped, not copied. Throws std::bad_alloc; `pages` is
/// unchanged then. Precondition: `bytes` is not less than its size.
void enlarge(OwnedPages& pages, std::size_t bytes);

}  // namespace sightline

// Tests: tests/unit/store/file_bytes_test.cpp
