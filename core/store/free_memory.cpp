#include "core/store/free_memory.h"

#include <malloc.h>

#include <utility>

#include "core/base/sanitizers.h"

namespace sightline {
namespace {

constexpr std::uint64_t kWorthIt = 64 << 10;

}  // namespace

void give_back_free_memory() {
  // A sanitizer brings its own allocator; glibc's was never set up then, and two threads that trim
  // it both begin to do so.
#if defined(__GLIBC__) && !defined(SIGHTLINE_WATCHED_HEAP)
  ::malloc_trim(0);
#endif
}

void give_back_free_memory_of(std::uint64_t bytes) {
  if (bytes >= kWorthIt) give_back_free_memory();
}

std::shared_ptr<const Scene> giving_back_memory(std::shared_ptr<const Scene> scene,
                                                std::uint64_t bytes) {
  if (bytes < kWorthIt) return scene;
  const Scene* const pointer = scene.get();
  return {pointer, [held = std::move(scene)](const Scene*) mutable {
            held.reset();
            give_back_free_memory();
          }};
}

}  // namespace sightline
