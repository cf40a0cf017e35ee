// glTF bytes of any kind: an answer, and when it is a scene, one whose every index is in range.
// Run:  cmake --preset fuzz && cmake --build --preset fuzz --target import_fuzz
// and then, from the root, build/fuzz/tests/fuzz/import_fuzz with
//       -dict=tests/fuzz/gltf.dict -max_len=8192 -max_total_time=600
//       build/import_corpus tests/data/hostile/cases tests/data/scenes

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "core/import/import.h"

namespace {

using namespace sightline;

/// Small enough that a hit of a limit is found by a small file, and that a run needs little memory.
ImportOptions small_limits() {
  ImportOptions options;
  options.limits.json_values = 100000;
  options.limits.triangles = 100000;
  options.limits.nodes = 10000;
  options.limits.instances = 10000;
  options.limits.geometry_bytes = 16u << 20;
  options.limits.zero_filled = 10000;
  return options;
}

void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

void check(const SceneDescription& scene) {
  for (const auto& mesh : scene.meshes) {
    require(mesh->indices.size() % 3 == 0, "three corners per triangle");
    for (std::uint32_t index : mesh->indices) {
      require(index < mesh->positions.size(), "corners are vertices");
    }
    std::uint32_t next = 0;
    for (const Primitive& primitive : mesh->primitives) {
      require(primitive.first_triangle == next, "primitives follow one another");
      next += primitive.triangle_count;
      require(primitive.material == 0xffffffffu || primitive.material < scene.materials.size(),
              "materials exist");
    }
    require(next == mesh->triangle_count() && next > 0, "primitives cover the mesh");
  }
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    require(scene.nodes[i].parent == 0xffffffffu || scene.nodes[i].parent < i,
            "parents stand before their children");
  }
  std::vector<bool> used(scene.meshes.size(), false);
  for (const Instance& instance : scene.instances) {
    require(instance.mesh < scene.meshes.size() && instance.node < scene.nodes.size(),
            "instances name a mesh and a node");
    used[instance.mesh] = true;
    for (const auto& row : instance.world_from_mesh.m) {
      for (double value : row) require(value - value == 0, "matrices are finite");
    }
  }
  for (bool is_used : used) require(is_used, "every mesh is placed");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto scene = import_bytes({reinterpret_cast<const std::byte*>(data), size}, small_limits());
  if (scene) {
    check(*scene);
  } else {
    require(!scene.error().code.empty() && scene.error().code != "GLTF_INTERNAL",
            "errors have a code");
    require(scene.error().message.size() < 1000, "messages do not echo the file");
  }
  return 0;
}

#ifdef SIGHTLINE_LIBFUZZER

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

/// Most changes of a GLB break its lengths and are refused at the door. Three times in four only
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
