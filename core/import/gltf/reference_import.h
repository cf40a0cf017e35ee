#pragma once
/// Reads what an import skips, to measure how much time skipping saves.

#include <cstddef>
#include <span>

#include "core/import/gltf/accessor.h"
#include "core/import/gltf/buffer_store.h"
#include "core/import/gltf/gltf_document.h"
#include "core/import/gltf/view_store.h"
#include "core/scene/scene_description.h"

namespace sightline::gltf {

/// Reads what the import that made `scene` did not read. That is every byte of the file, of its
/// buffers and of its images, and the positions and indices of every mesh that the scene does not
/// show. Stores nothing and ignores errors; the scene description does not change.
void read_what_was_skipped(const GltfDocument& document, std::span<const std::byte> file,
                           BufferStore& buffers, AccessorReader& accessors,
                           const ImportLimits& limits, const SceneDescription& scene);

}  // namespace sightline::gltf

// Tests: tests/unit/import/import_test.cpp
