#pragma once
/// Large memory directly from the system (mmap). Its pages take no memory before they are written,
/// and all of them return to the system when they are freed.

#include <cstddef>

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

}  // namespace sightline

// Tests: tests/unit/store/file_bytes_test.cpp
