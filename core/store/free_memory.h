#pragma once
/// Memory that was freed goes back to the system, not only to the allocator.

#include <cstdint>
#include <memory>

#include "core/scene/scene.h"

namespace sightline {

/// Returns unused memory to the system. The allocator retains freed memory that lies below younger
/// blocks. After a large scene or a file with much JSON, that is most of what it took. The free end
/// of each heap stays, up to the allocator's threshold (64 MiB at most). A lower threshold would
/// make the buffers of every large query fresh pages.
void give_back_free_memory();
/// Calls give_back_free_memory after work on so many bytes, if they are many. For few bytes it does
/// not pay: walking all heaps for each of ten thousand small scenes took longer than loading them.
void give_back_free_memory_of(std::uint64_t bytes);

/// Wraps a scene so that dropping the last reference returns its memory to the system, if its file
/// had enough bytes.
std::shared_ptr<const Scene> giving_back_memory(std::shared_ptr<const Scene> scene,
                                                std::uint64_t bytes);

}  // namespace sightline
