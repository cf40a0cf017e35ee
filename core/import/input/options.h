#pragma once
/// ImportOptions: the choices of a caller of an import.

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

/// Returns the bytes of a file beside the scene's file. `path` is relative, and uri.h has checked
/// it. The bytes must outlive the import.
using NeighbourFinder = std::function<Result<std::span<const std::byte>>(const std::string& path)>;

/// The choices for one import.
struct ImportOptions {
  ImportLimits limits = {};
  /// Index of the scene to load. Empty: the file's default scene, or its first scene, or every root
  /// node if it has no scenes.
  std::optional<std::uint32_t> scene = {};
  /// False: reads and discards everything that rays do not need as well (reference_import.h). The
  /// description is the same except for counts.touched; errors in what is discarded are ignored.
  bool skip = true;
  /// Only for import_bytes: finds files beside the scene's. Empty: there are none.
  NeighbourFinder neighbour = {};
  /// Only for import_bytes: owner of the bytes, which must not change while it lives. Meshes then
  /// refer to positions and indices in these bytes, unless they have to be converted. Null: they
  /// are copied. import_file always copies, because another process may write to the file.
  std::shared_ptr<const void> owner = {};
  /// Called with each part of the bytes that may be read after the import (SharedBytes::claim),
  /// from several threads at once. Only with an `owner`. Empty: not called.
  std::function<void(std::span<const std::byte>)> claim = {};
  /// True: vertex attributes (normals, texture coordinates, colours), and what poses and animations
  /// need, are copied if there is no `owner`, compressed ones as they are. False: without an
  /// `owner`, hits have no attributes, and poses cannot change. With an `owner` this has no effect:
  /// attributes are not read by the import, and hits read them in place.
  bool copies_attributes = false;
  /// Gets the stage "importing", with the nodes as its total. If it is cancelled, the import ends
  /// early with CANCELLED. May be null.
  Progress* progress = nullptr;
};

}  // namespace sightline

// Tests: tests/unit/import/gltf_document_test.cpp
