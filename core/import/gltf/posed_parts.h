#pragma once
/// PosedParts: the bytes of a file that its Poser needs after the import, and retains.

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "core/import/gltf/file_poser.h"
#include "core/import/input/retained_bytes.h"

namespace sightline::gltf {

/// The bytes of a file that stay valid.
struct Retained {
  SharedBytes file;                                  ///< at least the parts that are needed
  std::span<const std::byte> json;                   ///< the text of the document, in `file`
  std::optional<std::span<const std::byte>> binary;  ///< of a GLB file: its chunk, in `file`
  /// By buffer in another file: the parts that are needed.
  std::map<std::size_t, std::shared_ptr<const RetainedBytes>> buffers;
  std::vector<std::size_t> data_uris;  ///< buffers that are parts of the JSON, and were opened
  std::uint64_t copied = 0;            ///< bytes that were copied
};

/// Collects which buffer views the poses and animations of a file need.
class PosedParts {
 public:
  /// `morph_targets` is the number of targets of each mesh. Both must outlive this object.
  PosedParts(const ImportedFile& file, const std::vector<std::uint32_t>& morph_targets)
      : file_(file), morph_targets_(morph_targets) {}

  /// Adds what poses the mesh of a node; nothing if it has neither a skin nor morph targets.
  void add_node(const tinygltf::Node& node);
  /// Adds the keys of an animation.
  void add_animation(const AnimationEntry& animation);
  /// True if a node or an animation needs something.
  bool has_any() const { return has_any_; }

  /// Claims the parts of a file that has an owner, and copies them otherwise. Errors: GLTF_LIMIT_* if
  /// the budget has no room for copies; those of BufferStore. Throws std::bad_alloc.
  Result<Retained> retain(Budget& budget);

 private:
  void add_primitive(std::size_t mesh, std::size_t number, const tinygltf::Primitive& primitive);
  void add_accessor(int index);
  void add(int view) { views_.insert(static_cast<std::size_t>(view)); }
  void add_view(std::size_t number, FileParts& own, std::map<std::size_t, FileParts>& others);

  const ImportedFile& file_;
  const std::vector<std::uint32_t>& morph_targets_;
  bool has_any_ = false;
  std::set<std::size_t> meshes_, views_;
};

}  // namespace sightline::gltf

// Tests: tests/integration/poses_test.py
