#pragma once
/// AttributeReader: finds the vertex attributes of a primitive that hits may request, without
/// reading them.

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "core/base/result.h"
#include "core/base/shared_column.h"
#include "core/import/gltf/accessor.h"
#include "core/import/gltf/corners.h"
#include "core/import/gltf/gltf_document.h"
#include "core/import/gltf/posed_numbers.h"
#include "core/import/gltf/primitive_source.h"
#include "core/import/gltf/stored_numbers.h"
#include "core/import/gltf/view_store.h"
#include "core/import/input/budget.h"
#include "core/import/input/warnings.h"
#include "core/scene/mesh.h"

namespace sightline::gltf {

/// Attaches vertex attributes (normals, texture coordinates, colours, tangents, and those that the
/// file names) to meshes during an import.
/// Not thread-safe.
class AttributeReader {
 public:
  /// If `shared` has an owner, attributes in its bytes are referred to. All others are copied, or
  /// left out if `copies` is false. All arguments must outlive the reader; the attached attributes
  /// need only the owner of `shared`, which they hold.
  AttributeReader(const GltfDocument& document, AccessorReader& accessors,
                  const SharedBytes& shared, bool copies, Budget& budget, Warnings& warnings)
      : document_(document),
        views_(accessors.views()),
        accessors_(accessors),
        shared_(shared),
        copies_(copies),
        limits_(budget.limits()),
        budget_(budget),
        warnings_(warnings) {}

  /// Attaches the attributes of a primitive to the last primitive of `mesh`, which uses the
  /// vertices of `range`; `first_vertex` is the index in the mesh of the first of them. Attributes
  /// that `pose` changes are posed when they are loaded (posed_numbers.h). An invalid attribute is
  /// left out with a warning. Opens and decodes only buffers that geometry has needed before.
  void append(const PrimitiveSource& found, const Pose& pose, const CornerRange& range,
              std::uint32_t first_vertex, Mesh& mesh);

 private:
  using Numbers = std::shared_ptr<const VertexNumbers>;
  using LateView = LateDecoded<std::unique_ptr<std::byte[]>>;
  using LateDraco = LateDecoded<DracoMesh>;
  /// A requested attribute of a primitive.
  struct Wanted {
    const AttributeEntry& entry;
    const std::vector<AttributeEntry>& all;  ///< of the primitive
    std::pair<std::size_t, std::size_t> primitive;
    const PrimitiveSource& found;
    const CornerRange& range;
    int accessor;
    bool is_added = false;  ///< true: what a morph target adds to the attribute
  };

  Result<Numbers> find(const Wanted& wanted);
  /// As `numbers`, which are those of wanted, in a pose; null if a part cannot be retained. `skin`
  /// is that of the primitive; null: it is made if it is needed.
  Result<Numbers> posed(const Wanted& wanted, const Pose& pose, Numbers numbers,
                        std::shared_ptr<const SkinTurn>& skin);
  /// The skin of a primitive; null if a part cannot be retained.
  Result<std::shared_ptr<const SkinTurn>> skin_of(const PrimitiveSource& found,
                                                  const CornerRange& range);
  /// Numbers of a view whose bytes stay valid, or a copy; null if `copies` is false.
  Result<Numbers> keep(const AccessorView& view, const CornerRange& range);
  bool is_at_hand(std::size_t accessor) const;
  Result<Numbers> find_stored(const Wanted& wanted);
  Result<Numbers> find_meshopt(const Wanted& wanted, std::size_t view);
  Result<Numbers> find_draco(const Wanted& wanted, std::uint32_t id);
  Status check(const Wanted& wanted, const AccessorView& view) const;
  bool is_of_its_type(const Wanted& wanted, const AccessorView& view) const;
  /// True if every byte of the view stays valid after the import.
  bool is_kept(const AccessorView& view) const;
  Result<Numbers> copy(const AccessorView& view, const CornerRange& range);
  /// Compressed bytes that stay valid after the import; empty if they would have to be copied and
  /// `copies` is false.
  Result<std::optional<SharedColumn<std::byte>>> hold(std::span<const std::byte> compressed);
  bool is_held(std::span<const std::byte> bytes) const {
    return !bytes.empty() && !shared_.share<std::byte>(bytes.data(), bytes.size()).empty();
  }

  const GltfDocument& document_;
  ViewStore& views_;
  AccessorReader& accessors_;
  const SharedBytes& shared_;
  const bool copies_;
  const ImportLimits& limits_;
  Budget& budget_;
  Warnings& warnings_;
  std::map<const JointMatrices*, std::shared_ptr<const JointMatrices>> joints_;
  std::map<std::size_t, std::shared_ptr<const LateView>> late_views_;
  std::map<std::pair<std::size_t, std::size_t>, std::shared_ptr<const LateDraco>> late_draco_;
};

}  // namespace sightline::gltf
