#include "core/import/import.h"

#include <algorithm>
#include <exception>
#include <new>
#include <string_view>

#include "core/import/gltf/accessor.h"
#include "core/import/gltf/alpha_image.h"
#include "core/import/gltf/alpha_materials.h"
#include "core/import/gltf/buffer_store.h"
#include "core/import/gltf/file_poser.h"
#include "core/import/gltf/glb_container.h"
#include "core/import/gltf/gltf_attributes.h"
#include "core/import/gltf/gltf_document.h"
#include "core/import/gltf/hierarchy.h"
#include "core/import/gltf/instancing.h"
#include "core/import/gltf/mesh_reader.h"
#include "core/import/gltf/reference_import.h"
#include "core/import/gltf/transform.h"
#include "core/import/gltf/view_store.h"
#include "core/import/input/budget.h"
#include "core/import/input/mapped_file.h"
#include "core/import/input/refusal.h"
#include "core/import/input/warnings.h"
#include "core/import/pov/pov_scene.h"
#include "core/scene/node_changes.h"

namespace sightline {

namespace {

using namespace gltf;

/// The JSON text of either kind of file, and the BIN chunk of a GLB.
Result<GlbChunks> open_container(std::span<const std::byte> bytes, Warnings& warnings) {
  if (!has_glb_magic(bytes)) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::size_t byte_order_mark = text.rfind("\xef\xbb\xbf", 0) == 0 ? 3 : 0;
    const std::size_t first = text.find_first_not_of(" \t\r\n", byte_order_mark);
    if (first == std::string_view::npos || text[first] != '{') {
      return malformed("GLTF_CONTAINER_INVALID",
                       bytes.empty() ? "the file is empty"
                                     : "the file begins neither like a GLB (\"glTF\") nor like "
                                       "glTF's JSON (\"{\")");
    }
    return GlbChunks{bytes, std::nullopt, 0};
  }
  auto chunks = split_glb(bytes);
  if (chunks && chunks->bytes_after_end > 0) {
    warnings.add("GLB: " + std::to_string(chunks->bytes_after_end) +
                 " bytes after the end of the file were ignored");
  }
  if (chunks && chunks->unaligned_chunk) {
    warnings.add("GLB: the length of chunk " + std::to_string(*chunks->unaligned_chunk) +
                 " is not a multiple of 4; read as it stands");
  }
  return chunks;
}

/// Instances of every node that shows a mesh with triangles, in the order of the walk.
Status place_meshes(const GltfDocument& document, AccessorReader& accessors, MeshReader& meshes,
                    const ImportLimits& limits, Progress* progress, Budget& budget,
                    SceneDescription& scene) {
  if (progress != nullptr) progress->begin("importing", scene.nodes.size());
  for (std::uint32_t i = 0; i < scene.nodes.size(); ++i) {
    if (progress != nullptr) {
      if (progress->cancelled()) {
        return Error{ErrorKind::kCancelled, "CANCELLED", "the import was cancelled", ""};
      }
      progress->reach(i);
    }
    const std::uint32_t file_node = scene.nodes[i].file_node;
    const tinygltf::Node& source = document.model.nodes[file_node];
    if (source.mesh < 0) continue;
    auto mesh = meshes.mesh_of(source);
    if (!mesh) return mesh.error();
    const std::uint64_t room = limits.instances - scene.instances.size();
    const bool is_posed = source.skin >= 0;  // then the mesh stands in the world already
    auto placements = read_placements(document, file_node, accessors, room);
    if (!placements) return placements.error();
    const std::uint64_t count = placements->has_value() ? (*placements)->size() : 1;
    if (!mesh->has_value()) continue;
    if (count > room) {
      return beyond_limit("INSTANCES", "node " + std::to_string(file_node) + ": instances so far",
                          scene.instances.size() + count, limits.instances);
    }
    const std::uint64_t bytes = sizeof(Instance) + (placements->has_value() ? sizeof(Affine) : 0);
    if (Status status = budget.spend_bytes(count * bytes); !status) return status;
    const Affine& node = scene.nodes[i].world_from_node;
    if (!placements->has_value()) {
      scene.instances.push_back({**mesh, i, is_posed ? Affine{} : node});
      scene.instances.back().posed = is_posed;
      continue;
    }
    if (is_posed) {
      return invalid("GLTF_INSTANCING_INVALID",
                     "node " + std::to_string(file_node) + ": has both a skin and instances",
                     "/nodes/" + std::to_string(file_node));
    }
    const std::size_t first = scene.placements.size();
    if (first == 0) {
      scene.placements = std::move(**placements);
    } else {
      scene.placements.insert(scene.placements.end(), (*placements)->begin(), (*placements)->end());
    }
    // At least doubled, so that many nodes of few instances do not copy all each time.
    const std::size_t needed = scene.instances.size() + count;
    if (needed > scene.instances.capacity())
      scene.instances.reserve(std::max(needed, 2 * scene.instances.capacity()));
    for (std::size_t number = first; number < scene.placements.size(); ++number) {
      scene.instances.push_back(
          {**mesh, i, node * scene.placements[number], static_cast<std::uint32_t>(number)});
      if (!is_in_range(scene.instances.back().world_from_mesh)) {
        return invalid("GLTF_TRANSFORM_INVALID",
                       "node " + std::to_string(file_node) +
                           ": the matrix of an instance holds more than a float32 can hold",
                       "/nodes/" + std::to_string(file_node));
      }
    }
  }
  return success();
}

/// Moves the extras of the loaded nodes to the scene.
Status take_extras(GltfDocument& document, Budget& budget, SceneDescription& scene) {
  constexpr std::uint64_t kEntryBytes = 96;
  std::map<std::uint32_t, std::string> extras;
  for (std::uint32_t i = 0; i < scene.nodes.size() && !document.extras.empty(); ++i) {
    const auto found = document.extras.find(scene.nodes[i].file_node);
    if (found == document.extras.end()) continue;
    const std::uint64_t bytes = kEntryBytes + found->second.size();
    if (Status status = budget.spend_bytes(bytes); !status) return status;
    extras.emplace_hint(extras.end(), i, std::move(found->second));
  }
  if (!extras.empty()) {
    scene.extras = std::make_shared<const std::map<std::uint32_t, std::string>>(std::move(extras));
  }
  return success();
}

Result<SceneDescription> import_checked(std::span<const std::byte> bytes,
                                        std::optional<std::filesystem::path> file,
                                        const ImportOptions& options) {
  const ImportLimits& limits = options.limits;
  if (bytes.size() > limits.file_bytes) {
    return beyond_limit("FILE_BYTES", "bytes of the file", bytes.size(), limits.file_bytes);
  }
  if (const std::string_view whole(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      !has_glb_magic(bytes) && pov::looks_like_pov(whole)) {
    if (options.scene.value_or(0) != 0) {
      return invalid("GLTF_SCENE_UNKNOWN", "scene " + std::to_string(*options.scene) +
                                               " was asked for, a .pov file has 1");
    }
    return pov::import_boxes(whole, limits);
  }
  Warnings warnings;
  auto chunks = open_container(bytes, warnings);
  if (!chunks) return chunks.error();
  const std::string_view text(reinterpret_cast<const char*>(chunks->json.data()),
                              chunks->json.size());
  will_need(chunks->json);
  auto document = read_document(text, options);
  if (!document) return document.error();
  for (std::string& warning : document->warnings) warnings.add(std::move(warning));

  SceneDescription scene;
  if (document->has_scene) scene.name = document->model.scenes[0].name;
  scene.materials = std::move(document->materials);
  auto nodes = walk_scene(*document, limits, warnings);
  if (!nodes) return nodes.error();
  scene.nodes = *std::move(nodes);
  for (std::uint32_t i = 0; i < scene.nodes.size() && !document->camera_of_node.empty(); ++i) {
    const auto shown = document->camera_of_node.find(scene.nodes[i].file_node);
    if (shown == document->camera_of_node.end()) continue;
    scene.cameras.push_back(*document->cameras[shown->second]);
    scene.cameras.back().node = i;
  }

  BufferStore buffers(document->buffers, chunks->binary, std::move(file), limits,
                      options.neighbour);
  Budget budget(limits);
  ViewStore views(*document, buffers, budget);
  AccessorReader accessors(*document, views, limits);
  const SharedBytes shared{bytes, options.owner, options.claim};
  MeshReader meshes(*document, accessors, shared, options.copies_attributes, budget, scene,
                    warnings);
  Status placed =
      place_meshes(*document, accessors, meshes, limits, options.progress, budget, scene);
  if (Status loaded = meshes.finish(); !loaded) return loaded.error();
  if (!placed) return placed.error();
  list_named_attributes(*document, scene);
  attach_poser({*document, buffers, accessors, shared, *chunks, options}, budget, scene, warnings);
  for (const int view : accessors.unaligned()) {
    const auto& source = document->model.bufferViews[static_cast<std::size_t>(view)];
    warnings.add("bufferView " + std::to_string(view) + ": starts at byte " +
                 std::to_string(source.byteOffset) +
                 ", which is not aligned to its components; read as it stands");
  }
  if (Status taken = take_extras(*document, budget, scene); !taken) return taken.error();
  if (!document->masks.empty()) {
    const auto masks = node_masks(scene);
    for (Instance& instance : scene.instances) instance.mask = masks[instance.node];
  }

  if (Status status =
          attach_alpha(*document, views, shared, options.copies_attributes, budget, scene);
      !status) {
    return status.error();
  }

  ImportCounts& counts = scene.counts;
  counts.skipped = document->skipped;
  counts.skipped.nodes = document->model.nodes.size() - scene.nodes.size();
  counts.skipped.meshes = document->model.meshes.size() - meshes.shown();
  counts.touched = accessors.touched();
  counts.touched.json = text.size();
  counts.touched.compressed = views.compressed_bytes();
  counts.file_bytes = bytes.size() + buffers.external_bytes();
  if (!options.skip) {
    read_what_was_skipped(*document, bytes, buffers, accessors, limits, scene);
    counts.file_bytes = bytes.size() + buffers.external_bytes();
    counts.touched.others = counts.file_bytes - std::min(counts.touched.total(), counts.file_bytes);
  }
  counts.bytes_touched = counts.touched.total();
  scene.warnings = warnings.take();
  add_alpha_warnings(scene);
  return scene;
}

/// The border of this room: what libraries throw becomes an Error.
template <class Import>
Result<SceneDescription> guarded(const Import& import) {
  try {
    return import();
  } catch (const std::bad_alloc&) {
    return Error{ErrorKind::kOutOfSpace, "GLTF_OUT_OF_MEMORY", "not enough memory for this file",
                 ""};
  } catch (const std::exception&) {
    return Error{ErrorKind::kInternal, "GLTF_INTERNAL", "the file could not be read", ""};
  }
}

}  // namespace

Result<SceneDescription> import_file(const std::filesystem::path& file,
                                     const ImportOptions& options) {
  return guarded([&]() -> Result<SceneDescription> {
    auto mapped = MappedFile::open(file, options.limits.file_bytes,
                                   "\"" + shortened(file.filename().string()) + "\"");
    if (!mapped) return mapped.error();
    mapped->read_sparsely();
    return import_checked(mapped->bytes(), file, options);
  });
}

Result<SceneDescription> import_bytes(std::span<const std::byte> bytes,
                                      const ImportOptions& options) {
  return guarded([&] { return import_checked(bytes, std::nullopt, options); });
}

}  // namespace sightline
