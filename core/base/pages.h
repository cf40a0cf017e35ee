#pragma once
/// Large memory straight from the system: nothing of it is touched before its owner does, and all
/// of it goes back at once.

#include <cstddef>

namespace sightline {

/// Less than this is better taken from the allocator, and stays on small pages, so that a scene of
/// ten thousand little meshes does not take 2 MiB for each.
inline constexpr std::size_t kLargeMemory = 8u << 20;

/// Up to whole pages.
std::size_t whole_pages(std::size_t bytes);
/// `bytes` of zeros, on huge pages where the system has them and bytes >= kLargeMemory. Throws
/// std::bad_alloc.
void* take_pages(std::size_t bytes);
/// Unmaps [pages, pages + bytes). Precondition: an allocation of take_pages or a part of one that
/// begins at a page.
void give_pages(void* pages, std::size_t bytes);

}  // namespace sightline

// Tests: tests/unit/store/file_bytes_test.cpp
