// Files of trees: whatever bytes decode_trees takes for the trees of a scene must answer rays as
// the trees do that were built. Input: a byte that says whether hashes and sizes are to be made
// right first, then the file.
// Run:  scripts/stress.sh fuzz --target trees_fuzz

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include "core/base/column.h"
#include "core/scene/scene.h"
#include "core/scene/tree_cache.h"
#include "core/scene/tree_cache_format.h"
#include "core/trace/kernel/kernel.h"

using namespace sightline;

namespace {

/// Six triangles that join, and two placements whose sizes keep them out: three entries and a top.
std::shared_ptr<const Scene> make_scene() {
  auto mesh = std::make_shared<Mesh>();
  // A strip: neighbours share two vertices.
  for (std::uint32_t i = 0; i < 8; ++i) {
    const float y = i % 2 == 0 ? 0.0f : 4.0f;
    mesh->positions.own().push_back({2.0f * static_cast<float>(i), y, i % 4 < 2 ? 2.0f : -2.0f});
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    for (const std::uint32_t corner : {i, i + 1, i + 2}) mesh->indices.own().push_back(corner);
  }
  mesh->primitives = {{0, 6}};
  SceneDescription description;
  description.meshes = {std::move(mesh)};
  description.nodes.resize(1);
  for (const double size : {1.0, 1e30, 1e-30}) {
    Instance instance;
    for (int k = 0; k < 3; ++k) instance.world_from_mesh.m[k][k] = size;
    description.instances.push_back(instance);
  }
  return *Scene::build(std::move(description));
}

RayBatch make_rays() {
  RayBatch rays;
  for (const double size : {1.0, 1e30, 1e-30}) {
    for (int i = 0; i < 16; ++i) {
      const double y = (0.25 * i + 0.125) * size;
      rays.push_back({{-3 * size, y, 0.3 * size}, {1, 0, 0}});
      rays.push_back({{(0.8 * i + 0.1) * size, 9 * size, 0.5 * size}, {0, -1, 0.01 * i}});
    }
  }
  return rays;
}

std::array<Column<std::uint32_t>, 2> answers(const SceneView& scene, const RayBatch& rays) {
  HitBatch hits;
  hits.resize(rays.size());
  TraceCounts counts;
  supported_kernels().front().closest(scene, rays, 0, rays.size(), hits, counts);
  return {hits.instance, hits.triangle};
}

/// Makes header, records and hashes agree with what they are about, as far as they say where it is.
void seal(std::span<std::byte> bytes, std::uint64_t content) {
  using namespace tree_cache;
  if (bytes.size() < sizeof(Header)) return;
  Header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  const std::uint64_t count =
      std::min<std::uint64_t>(header.tree_count, (bytes.size() - sizeof header) / sizeof(Record));
  for (std::uint64_t i = 0; i < count; ++i) {
    std::byte* const at = bytes.data() + sizeof header + i * sizeof(Record);
    Record record;
    std::memcpy(&record, at, sizeof record);
    if (record.offset > bytes.size() || record.bytes > bytes.size() - record.offset) continue;
    record.hash = hash_in_pieces(bytes.subspan(record.offset, record.bytes));
    std::memcpy(at, &record, sizeof record);
  }
  const Header own = make_header();
  std::copy(std::begin(own.magic), std::end(own.magic), header.magic);
  header.version = own.version;
  header.byte_order = own.byte_order;
  header.node_bytes = own.node_bytes;
  header.block_bytes = own.block_bytes;
  header.arity = own.arity;
  header.lanes = own.lanes;
  header.content = content;
  header.file_bytes = bytes.size();
  header.tree_count = count;
  header.records_hash = hash_of(bytes.subspan(sizeof header, count * sizeof(Record)));
  header.hash = hash_of(header);
  std::memcpy(bytes.data(), &header, sizeof header);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::shared_ptr<const Scene> scene = make_scene();
  static const RayBatch rays = make_rays();
  static const auto truth = answers(*scene, rays);
  static const std::uint64_t content = content_hash(scene->trees().plan());
  if (size == 0) return 0;
  Column<std::byte> bytes(size - 1);
  // An empty column has no address to copy to.
  if (size > 1) std::memcpy(bytes.data(), data + 1, size - 1);
  if ((data[0] & 1) != 0) seal(bytes, content);
  auto tree = decode_trees(scene->trees().plan(), content, bytes, std::make_shared<const int>());
  if (!tree) return 0;
  const SceneView view(*scene, std::make_shared<const SceneTree>(std::move(*tree)));
  if (answers(view, rays) != truth) __builtin_trap();
  return 0;
}
