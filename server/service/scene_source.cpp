#include "server/service/scene_source.h"

#include <fcntl.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <future>
#include <limits>

#include "core/demo/demo.h"
#include "core/import/import.h"
#include "core/scene/overflow_geometry.h"
#include "core/store/posix_file.h"
#include "core/store/sha256.h"

namespace sightline {
namespace {

constexpr std::string_view kDemo = "demo:";

Error not_found(std::string message) {
  return {ErrorKind::kNotFound, "SOURCE_NOT_FOUND", std::move(message), ""};
}

struct Demo {
  std::string_view name;
  demo::DemoScene (*make)();
};
constexpr Demo kDemos[] = {{"town", [] { return demo::town(); }},
                           {"six", demo::six_triangles},
                           {"painted", demo::painted_square}};

Result<Demo> find_demo(std::string_view name) {
  const auto found = std::find_if(std::begin(kDemos), std::end(kDemos),
                                  [&](const Demo& demo) { return demo.name == name; });
  if (found != std::end(kDemos)) return *found;
  return not_found("there is no demo '" + std::string(name) + "'; there are town, six and painted");
}

Result<std::shared_ptr<const Scene>> make(Result<SceneDescription> description, Progress& progress,
                                          Laziness laziness, const OverflowFor& overflow_for,
                                          std::span<const NodeChange> changes = {}) {
  if (!description) return std::move(description).error();
  if (!changes.empty()) {
    if (auto changed = change_nodes(*description, changes); !changed) return changed.error();
  }
  if (progress.cancelled()) return load_cancelled();
  progress.begin("building");
  if (overflow_for) {
    // Nothing has room for so much: the file may be there.
    description->overflow = overflow_for(std::numeric_limits<std::uint64_t>::max());
    if (overflow_for(geometry_bytes(*description)) != nullptr) {
      if (Status moved = move_geometry(*description); !moved) return moved.error();
      laziness = Laziness::kWhenNeeded;
    }
  }
  if (laziness != Laziness::kEager) return Scene::prepare(std::move(*description));
  return Scene::build(std::move(*description), TreeQuality::kHigh, Joining::kMeasured,
                      &progress.flag());
}

ImportOptions options_of(const SceneChoice& choice, Progress& progress, Laziness laziness) {
  ImportOptions options;
  options.scene = choice.scene;
  options.skip = laziness != Laziness::kEager;
  options.progress = &progress;
  return options;
}

/// What hits may ask of the corners of a mesh.
void add_attributes(const Mesh& mesh, Sha256& hash) {
  for (std::size_t k = 0; k < mesh.attributes.size(); ++k) {
    const Primitive& part = mesh.primitives[k];
    const PrimitiveAttributes& attributes = mesh.attributes[k];
    const std::size_t begin = std::size_t{part.first_triangle} * 3;
    for (const auto& entry : attributes.entries) {
      for (std::size_t i = 0; i < std::size_t{part.triangle_count} * 3; ++i) {
        double values[4] = {};
        std::uint64_t touched = 0;
        entry.numbers->load(mesh.indices[begin + i] + attributes.first_vertex, values, touched);
        hash.update(std::as_bytes(std::span(values)));
      }
    }
  }
}

/// As if they were listed.
void add_indices(const IndexColumn& indices, Sha256& hash) {
  std::array<std::uint32_t, 1024> some;
  for (std::size_t begin = 0; begin < indices.size(); begin += some.size()) {
    const std::size_t count = std::min(some.size(), indices.size() - begin);
    for (std::size_t i = 0; i < count; ++i) some[i] = indices[begin + i];
    hash.update(std::as_bytes(std::span(some).first(count)));
  }
}

/// The hash of everything that can come from other files than the named one.
std::string hash_of_geometry(const SceneDescription& description) {
  Sha256 hash;
  for (const auto& mesh : description.meshes) {
    hash.update(std::as_bytes(std::span(mesh->positions)));
    add_indices(mesh->indices, hash);
    add_attributes(*mesh, hash);
  }
  for (const Instance& instance : description.instances) {
    hash.update(std::as_bytes(std::span(instance.world_from_mesh.m)));
  }
  return hash.finish();
}

}  // namespace

Result<std::shared_ptr<const Scene>> load_scene(const LoadInput& input, Laziness laziness,
                                                const OverflowFor& overflow_for) {
  input.progress.begin("importing");
  ImportOptions options = options_of(input.choice, input.progress, laziness);
  options.neighbour = input.neighbour;
  options.owner = input.owner;
  options.claim = input.claim;
  options.copies_attributes = true;
  return make(import_bytes(input.bytes, options), input.progress, laziness, overflow_for,
              input.changes);
}

Result<std::vector<std::byte>> demo_glb(const std::string& name) {
  const auto demo = find_demo(name);
  if (!demo) return demo.error();
  return demo::write_glb(demo->make());
}

Status check_source(const std::string& source) {
  if (source.starts_with(kDemo)) {
    const auto demo = find_demo(std::string_view(source).substr(kDemo.size()));
    return demo ? success() : demo.error();
  }
  std::error_code error;
  if (std::filesystem::is_regular_file(source, error)) return success();
  if (error && error != std::errc::no_such_file_or_directory) {
    return not_found("cannot read '" + source + "': " + error.message());
  }
  return not_found("there is no file '" + source + "'");
}

/// Sets size and SHA-256 of what the file has. Errors: those of io_error.
static Status hash_file(const FileDescriptor& file, const char* doing, PreloadedScene& loaded) {
  std::vector<std::byte> piece(1 << 20);
  Sha256 hash;
  for (;;) {
    const auto size = read_at(file, loaded.bytes, piece, doing);
    if (!size) return size.error();
    hash.update(std::span(piece).first(*size));
    loaded.bytes += *size;
    if (*size < piece.size()) break;
  }
  loaded.sha256 = hash.finish();
  return success();
}

Result<PreloadedScene> load_source(const std::string& source, const SceneChoice& choice,
                                   Progress& progress, Laziness laziness, bool with_attributes,
                                   const OverflowFor& overflow_for) {
  if (Status found = check_source(source); !found) return std::move(found).error();
  PreloadedScene loaded;
  Result<std::shared_ptr<const Scene>> scene = loaded.scene;
  if (source.starts_with(kDemo)) {
    auto glb = demo_glb(source.substr(kDemo.size()));
    if (!glb) return std::move(glb).error();
    loaded.bytes = glb->size();
    loaded.sha256 = sha256_of(*glb);
    scene = load_scene({*glb, choice, progress, loaded.sha256}, laziness, overflow_for);
  } else {
    constexpr const char* kDoing = "read the scene's file";
    auto file = open_file(source, O_RDONLY, kDoing);
    if (!file) return std::move(file).error();
    // The import does not need the hash. Without a free thread it is computed by get().
    auto hashing = std::async(std::launch::async | std::launch::deferred,
                              [&] { return hash_file(*file, kDoing, loaded); });
    // By name and not from these bytes: a .gltf may have neighbours.
    progress.begin("importing");
    ImportOptions options = options_of(choice, progress, laziness);
    options.copies_attributes = with_attributes;
    auto description = import_file(source, options);
    if (!description) return std::move(description).error();
    if (Status hashed = hashing.get(); !hashed) return std::move(hashed).error();
    if (description->counts.file_bytes > loaded.bytes) {
      loaded.neighbours = hash_of_geometry(*description);
    }
    scene = make(std::move(description), progress, laziness, overflow_for);
  }
  if (!scene) return std::move(scene).error();
  loaded.scene = std::move(*scene);
  return loaded;
}

}  // namespace sightline
