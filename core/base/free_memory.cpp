#include "core/base/free_memory.h"

#include <malloc.h>

#include "core/base/sanitizers.h"

namespace sightline {

void give_back_free_memory() {
  // A sanitizer brings its own allocator; glibc's was never set up then, and two threads that trim
  // it both begin to do so.
#if defined(__GLIBC__) && !defined(SIGHTLINE_WATCHED_HEAP)
  ::malloc_trim(0);
#endif
}

}  // namespace sightline
