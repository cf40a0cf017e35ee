// glTF bytes of any kind: an answer, and when it is a scene, one whose every index is in range.
// Run:  scripts/stress.sh fuzz --target import_fuzz

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "core/scene/node_changes.h"
#include "tests/fuzz/scene_check.h"

using namespace sightline;

namespace {

/// What hits read where the file keeps it is what they read of the copy.
void check_attributes(const Mesh& shared, const Mesh& copied) {
  fuzz::each_attribute(shared, [&](std::size_t primitive, VertexAttribute attribute,
                                   const VertexNumbers& numbers, std::uint32_t vertex) {
    if (primitive >= copied.attributes.size()) return;
    const VertexNumbers* const copy = copied.attributes[primitive].of(attribute);
    if (copy == nullptr) return;  // there was no room for it
    double a[4] = {}, b[4] = {};
    std::uint64_t touched = 0;
    const bool loaded = numbers.load(vertex, a, touched);
    fuzz::require(loaded == copy->load(vertex, b, touched), "both are there or neither");
    const auto is_same_bits = [](double x, double y) {
      return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
    };
    fuzz::require(std::equal(a, a + 4, b, is_same_bits), "attributes");
  });
}

/// Where the bytes are kept, meshes may look at them: the same meshes.
void check_sharing(const SceneDescription& copied, std::span<const std::byte> bytes) {
  const auto kept = std::make_shared<const std::vector<std::byte>>(bytes.begin(), bytes.end());
  ImportOptions options = fuzz::small_limits();
  options.owner = kept;
  const auto shared = import_bytes(*kept, options);
  fuzz::check(shared);
  fuzz::require(shared.ok() && shared->meshes.size() == copied.meshes.size(), "as many meshes");
  for (std::size_t i = 0; i < copied.meshes.size(); ++i) {
    const auto same = [](const auto& a, const auto& b) {
      return a.size() == b.size() &&
             std::memcmp(a.data(), b.data(), a.size() * sizeof *a.data()) == 0;
    };
    fuzz::require(same(shared->meshes[i]->positions, copied.meshes[i]->positions), "positions");
    fuzz::require(shared->meshes[i]->indices == copied.meshes[i]->indices, "indices");
    check_attributes(*shared->meshes[i], *copied.meshes[i]);
  }
}

/// Other poses of the scene: an error, or a scene whose every index is in range.
void check_poses(const SceneDescription& scene) {
  constexpr std::size_t kMost = 6;
  if (scene.poser == nullptr) return;
  const auto check = [&](const std::vector<NodeChange>& changes) {
    SceneDescription posed = scene;
    const auto changed = change_nodes(posed, changes);
    if (!changed) {
      fuzz::require(!changed.error().code.empty() && !changed.error().message.empty(), "an error");
      return;
    }
    fuzz::require(posed.instances.size() == scene.instances.size(), "as many instances");
    for (std::size_t i = 0; i < posed.instances.size(); ++i) {
      const Instance& instance = posed.instances[i];
      fuzz::require(instance.mesh < posed.meshes.size(), "a mesh");
      const Mesh& mesh = *posed.meshes[instance.mesh];
      const Mesh& before = *scene.meshes[scene.instances[i].mesh];
      fuzz::require(mesh.triangle_count() == before.triangle_count(), "as many triangles");
      for (const std::uint32_t index : mesh.indices.listed()) {
        fuzz::require(index < mesh.positions.size(), "an index");
      }
    }
  };
  const auto animations = scene.poser->animations();
  for (std::uint32_t i = 0; animations && i < std::min(animations->size(), kMost); ++i) {
    for (const double seconds : {-1.0, 0.4, 1e308}) {
      const auto changes = scene.poser->sample({{}, i, seconds});
      if (changes) check(*changes);
    }
  }
  std::vector<NodeChange> changes;
  for (const Node& node : scene.nodes) {
    if ((!node.is_joint && node.morph_targets == 0) || changes.size() == kMost) continue;
    NodeChange change;
    change.node = node.file_node;
    change.weights.assign(node.morph_targets, 0.5);
    if (node.is_joint) change.parent_from_node = Affine{};
    changes.push_back(change);
    check({change});
  }
  check(changes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  const auto scene = import_bytes(bytes, fuzz::small_limits());
  fuzz::check(scene);
  if (scene) check_sharing(*scene, bytes);
  if (scene) check_poses(*scene);
  return 0;
}

#ifdef SIGHTLINE_LIBFUZZER

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

/// Most changes of a GLB break its lengths and are refused at once. Three times in four only
/// one chunk's payload is changed and the lengths are put right.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, data + at, sizeof value);
    return std::size_t{value};
  };
  const bool is_glb = size >= 28 && std::memcmp(data, "glTF", 4) == 0 && word(12) % 4 == 0 &&
                      word(12) + 28 <= size && word(12) + 28 + word(20 + word(12)) == size;
  if (!is_glb || seed % 4 == 0 || most < size) return LLVMFuzzerMutate(data, size, most);

  std::vector<std::uint8_t> chunks[2] = {
      {data + 20, data + 20 + word(12)},
      {data + 28 + word(12), data + size},
  };
  std::vector<std::uint8_t>& chunk = chunks[seed / 4 % 2];
  const std::size_t length = chunk.size(), room = most - size + length;
  chunk.resize(room);
  chunk.resize(LLVMFuzzerMutate(chunk.data(), length, room / 4 * 4));
  while (chunk.size() % 4 != 0) chunk.push_back(&chunk == &chunks[0] ? ' ' : 0);

  const std::size_t total = 28 + chunks[0].size() + chunks[1].size();
  if (total > most || chunks[0].empty()) return LLVMFuzzerMutate(data, size, most);
  const auto put = [&](std::size_t at, std::size_t value) {
    const auto narrow = static_cast<std::uint32_t>(value);
    std::memcpy(data + at, &narrow, sizeof narrow);
  };
  put(8, total);
  put(12, chunks[0].size());
  std::memcpy(data + 20, chunks[0].data(), chunks[0].size());
  put(20 + chunks[0].size(), chunks[1].size());
  put(24 + chunks[0].size(), 0x004e4942);
  if (!chunks[1].empty()) {
    std::memcpy(data + 28 + chunks[0].size(), chunks[1].data(), chunks[1].size());
  }
  return total;
}

#endif
