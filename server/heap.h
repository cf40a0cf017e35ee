#pragma once
/// How much freed memory the allocator may keep.

namespace sightline {

/// Large requests come on many threads, and glibc would keep for each of up to eight heaps per core
/// the most that one ever needed: 400 MiB after 150 answers of 5 MB. Before any thread is made.
void bound_heaps();

}  // namespace sightline
