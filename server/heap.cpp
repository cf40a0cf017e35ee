#include "server/heap.h"

#include <malloc.h>

namespace sightline {

void bound_heaps() {
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  ::mallopt(M_ARENA_MAX, 4);
  // Buffers from here on are pages of their own, which are fresh each time: for a request of 30,000
  // rays that was 38.7 ms instead of 37.6; from 1 MiB on it would be a tenth of the request.
  ::mallopt(M_MMAP_THRESHOLD, 4 << 20);
  ::mallopt(M_TRIM_THRESHOLD, 8 << 20);
#endif
}

}  // namespace sightline
