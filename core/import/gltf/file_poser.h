#pragma once
/// Makes the Poser of an imported file: it retains what poses and animations need of the bytes.

#include <cstdint>
#include <memory>
#include <span>

#include "core/base/result.h"
#include "core/base/shared_column.h"
#include "core/import/gltf/accessor.h"
#include "core/import/gltf/buffer_store.h"
#include "core/import/gltf/glb_container.h"
#include "core/import/gltf/gltf_document.h"
#include "core/import/input/budget.h"
#include "core/import/input/warnings.h"
#include "core/scene/scene_description.h"

namespace sightline::gltf {

/// What an import knows of its file.
struct ImportedFile {
  const GltfDocument& document;
  BufferStore& buffers;
  AccessorReader& accessors;
  const SharedBytes& shared;  ///< the file; without an owner, what is retained is copied
  const GlbChunks& chunks;
  const ImportOptions& options;
};

/// Sets Node::morph_targets and Node::weights and, if the scene has skins, morph targets or animations, its poser. Adds a
/// warning for each animation that cannot be sampled, or if the budget has no room for what the
/// poser needs; then there is none. Buffers in other files or data URIs that the import did not open
/// are not opened. Reads no element. Throws std::bad_alloc. Precondition: the scene's nodes and
/// instances are complete.
void attach_poser(const ImportedFile& file, Budget& budget, SceneDescription& scene,
                  Warnings& warnings);

}  // namespace sightline::gltf

// Tests: tests/integration/poses_test.py
