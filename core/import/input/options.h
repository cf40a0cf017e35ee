#pragma once
/// What a caller of an import chooses.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/import/input/limits.h"

namespace sightline {

/// The bytes of a file beside the scene's, by its relative path, which has passed all checks of its
/// text; they outlive the import.
using NeighbourFinder = std::function<Result<std::span<const std::byte>>(const std::string& path)>;

struct ImportOptions {
  ImportLimits limits = {};
  /// Empty: the file's default scene, else its first, else (a file without scenes) every root node.
  std::optional<std::uint32_t> scene = {};
  /// False: everything that a ray does not need is read as well, and thrown away (reference_import.h). The
  /// description is the same but for counts.touched; what is wrong in the rest is no error.
  bool skip = true;
  /// For import_bytes. Empty: there are no other files.
  NeighbourFinder neighbour = {};
  /// For import_bytes. Owns the bytes, which must not change while it lives. Meshes then refer to
  /// positions and indices in place, unless these have to be changed. Null: they are copied.
  /// (import_file copies, because anybody may write to the file.)
  std::shared_ptr<const void> owner = {};
  /// Called with each part of those bytes that may be read after the import, from several threads.
  std::function<void(std::span<const std::byte>)> claim = {};
  /// Whether vertex attributes (normals, texture coordinates, colours) are copied, with what is
  /// compressed along with them. It matters only without a `owner`: with one, they are never read
  /// here, and hits read them in place. Without a `owner` and without copies no hit has
  /// attributes.
  bool copies_attributes = false;
  /// Reports the stage "importing", by nodes. The import ends early (CANCELLED) when it is
  /// cancelled. May be null.
  Progress* progress = nullptr;
};

}  // namespace sightline

// Tests: tests/unit/import/gltf_document_test.cpp
