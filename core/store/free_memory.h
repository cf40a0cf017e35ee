#pragma once
/// Memory that was freed goes back to the system, not only to the allocator.

#include <cstdint>
#include <memory>

#include "core/scene/scene.h"

namespace sightline {

/// Gives back what nothing uses. The allocator keeps freed memory for itself wherever something
/// younger lies beyond it; after a large scene or a file of much JSON that is most of what it took.
/// What stays is the free end of each heap, up to a threshold of the allocator's own (64 MiB at
/// most): to lower that would make the buffers of every large query fresh pages.
void give_back_free_memory();
/// The same after work on so many bytes. Little is not worth it: a walk over all of the allocator's
/// memory for each of ten thousand small scenes took longer than to load them.
void give_back_free_memory_of(std::uint64_t bytes);

/// The same scene; whoever lets go of it last gives its memory back, if its file had enough bytes.
std::shared_ptr<const Scene> giving_back_memory(std::shared_ptr<const Scene> scene,
                                                std::uint64_t bytes);

}  // namespace sightline
