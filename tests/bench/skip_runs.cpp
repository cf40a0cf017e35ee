#include "tests/bench/skip_runs.h"

#include <fcntl.h>
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <fstream>
#include <random>
#include <string>
#include <thread>

#include "core/base/content_hash.h"
#include "core/demo/demo.h"
#include "core/import/import.h"
#include "core/run/engine.h"
#include "core/store/file_bytes.h"
#include "core/store/posix_file.h"
#include "core/store/tree_cache_manager.h"
#include "proto/json/hit_json.h"
#include "tests/bench/embree_build.h"
#include "tests/bench/machine.h"
#include "tests/support/golden_hash.h"

namespace sightline::bench {
namespace {

constexpr std::size_t kRays = 10'000;

/// MiB, from /proc/self/status.
double memory_mib(const std::string& name) {
  std::ifstream status("/proc/self/status");
  std::string word;
  double kib = 0;
  while (status >> word) {
    if (word == name + ":" && status >> kib) return kib / 1024;
  }
  return 0;
}

/// The first goes down through the middle of an instance; the others cross the bounds at random.
RayBatch rays_into(const Scene& scene) {
  std::mt19937_64 random(7);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const Box3d& box = scene.bounds();
  const auto inside = [&] {
    Vec3d p;
    for (int k = 0; k < 3; ++k) p[k] = box.min[k] + unit() * (box.max[k] - box.min[k]);
    return p;
  };
  RayBatch rays;
  const auto& instances = scene.description().instances;
  const auto instance = static_cast<std::uint32_t>(instances.size() / 2);
  const auto triangles = scene.description().meshes[instances[instance].mesh]->triangle_count();
  const WorldTriangle aim = scene.world_triangle({instance, triangles / 2});
  const double x = (aim.v0.x + aim.v1.x + aim.v2.x) / 3, z = (aim.v0.z + aim.v1.z + aim.v2.z) / 3;
  rays.push_back({{x, box.max.y + (box.max.y - box.min.y) + 1, z}, {0, -1, 0}});
  while (rays.size() < kRays) {
    const Vec3d from = inside(), to = inside();
    const Vec3d way{to.x - from.x, to.y - from.y, to.z - from.z};
    if (way.x != 0 || way.y != 0 || way.z != 0) rays.push_back({from, way});
  }
  return rays;
}

RayBatch part_of(const RayBatch& rays, std::size_t begin, std::size_t end) {
  RayBatch part;
  for (std::size_t i = begin; i < end; ++i) part.push_back(rays[i]);
  return part;
}

std::uint64_t hash_of(const HitBatch& hits) {
  std::uint64_t hash = test::golden_hash(std::as_bytes(std::span(hits.t)));
  hash = hash * 31 + test::golden_hash(std::as_bytes(std::span(hits.instance)));
  return hash * 31 + test::golden_hash(std::as_bytes(std::span(hits.triangle)));
}

/// How long the answer to those hits is, as columns of JSON with these fields.
double bytes_out(const HitBatch& hits, const Column<HitDetail>& details, FieldSet fields) {
  const std::string text = encode_hits(hits, details, {}, fields, AnswerLayout::kColumns);
  return static_cast<double>(text.size()) / static_cast<double>(hits.size());
}

/// As a data folder's scene is read: checked by its fingerprint, and not copied.
Result<SceneDescription> import_stored(const std::filesystem::path& file) {
  constexpr const char* kDoing = "read the scene";
  auto opened = open_file(file, O_RDONLY, kDoing);
  if (!opened) return opened.error();
  std::uint64_t fingerprint = 0;
  auto read = FileBytes::read(*opened, kDoing, fingerprint);
  if (!read) return read.error();
  ImportOptions options;
  const auto manager = std::make_shared<const FileBytes>(std::move(*read));
  options.owner = manager;
  return import_bytes(manager->bytes(), options);
}

}  // namespace

nlohmann::json run_rays(const std::filesystem::path& file, bool lazy) {
  const auto engine = Engine::create({});
  const double start = wall_time_seconds();
  ImportOptions options;
  options.skip = lazy;
  auto description = import_file(file, options);
  if (!description) return {{"error", description.error().message}};
  const ImportCounts counts = description->counts;
  const double imported = wall_time_seconds();
  auto made =
      lazy ? Scene::prepare(std::move(*description)) : Scene::build(std::move(*description));
  if (!made) return {{"error", made.error().message}};
  const Scene& scene = **made;
  const double ready = wall_time_seconds();
  // Making rays is the client's time.
  const RayBatch rays = rays_into(scene);
  const double asked = wall_time_seconds();

  HitBatch all;
  nlohmann::json built = nlohmann::json::array();
  QueryWork work;
  double first = 0;
  std::size_t begin = 0;
  for (const std::size_t end : {std::size_t{1}, std::size_t{100}, kRays}) {
    HitBatch hits;
    const RayBatch part = part_of(rays, begin, end);
    RayOptions how;
    how.work = &work;
    if (!(*engine)->closest(scene, part, Deadline::never(), hits, how))
      return {{"error", "no answer"}};
    if (end == 1) first = wall_time_seconds() - asked;
    all.append(hits);
    const TreeStats stats = scene.trees().stats();
    built.push_back({{"rays", end}, {"meshes", stats.meshes_built}, {"trees", stats.trees_built}});
    begin = end;
  }
  const TreeStats stats = scene.trees().stats();
  // What nobody asks for is neither computed nor printed.
  Column<HitDetail> details;
  const FieldSet asked_for = lazy ? FieldSet{HitField::kT}
                                  : FieldSet{HitField::kT, HitField::kPosition, HitField::kNormal,
                                             HitField::kBarycentrics, HitField::kFront};
  if (!lazy && !(*engine)->details(scene, rays, all, Deadline::never(), details))
    return {{"error", "no details"}};
  const auto per_ray = [](std::uint64_t count) { return static_cast<double>(count) / kRays; };
  return {{"nodes_per_ray", per_ray(work.nodes)},
          {"blocks_per_ray", per_ray(work.blocks)},
          {"bytes_out_per_ray", bytes_out(all, details, asked_for)},
          {"import_seconds", imported - start},
          {"ready_seconds", ready - start},
          {"first_answer_seconds", ready - start + first},
          {"build_seconds", ready - imported},
          {"meshes_total", stats.meshes_total},
          {"triangles", scene.instanced_triangle_count()},
          {"built", built},
          {"bytes_touched", counts.bytes_touched},
          {"file_bytes", counts.file_bytes},
          {"peak_mib", memory_mib("VmHWM")},
          {"hash", std::to_string(hash_of(all))}};
}

nlohmann::json run_server(const std::filesystem::path& file, const std::filesystem::path& folder) {
  const auto engine = Engine::create({});
  TreeCacheOptions options;
  options.folder = folder;
  TreeCacheManager manager(options);
  const double start = wall_time_seconds();
  auto description = import_stored(file);
  if (!description) return {{"error", description.error().message}};
  auto scene = Scene::prepare(std::move(*description));
  if (!scene) return {{"error", scene.error().message}};
  const double ready = wall_time_seconds();
  const RayBatch rays = rays_into(**scene);
  const double asked = wall_time_seconds();
  if (!manager.adopt(*scene)) return {{"error", "not adopted"}};
  HitBatch hits;
  if (!(*engine)->closest(**scene, part_of(rays, 0, 1), Deadline::never(), hits))
    return {{"error", "no answer"}};
  const double first = wall_time_seconds() - asked;
  manager.wait_until_idle();
  const double settled = wall_time_seconds() - asked;
  if (!(*engine)->closest(**scene, rays, Deadline::never(), hits)) return {{"error", "no answer"}};
  malloc_trim(0);
  const TreeStats stats = (*scene)->trees().stats();
  return {{"first_answer_seconds", ready - start + first},
          {"settled_seconds", ready - start + settled},
          {"full_builds", stats.full_builds},
          {"cache_hits", stats.cache_hits},
          {"tree_mib", static_cast<double>(stats.tree_bytes) / 1048576},
          {"geometry_mib", static_cast<double>(stats.geometry_bytes) / 1048576},
          {"peak_mib", memory_mib("VmHWM")},
          {"final_mib", memory_mib("VmRSS")},
          {"hash", std::to_string(hash_of(hits))}};
}

nlohmann::json run_embree(const std::filesystem::path& file) {
  auto description = import_file(file, {});
  if (!description) return {{"error", description.error().message}};
  EmbreeBuild embree(*description, static_cast<int>(std::thread::hardware_concurrency()),
                     RTC_BUILD_QUALITY_MEDIUM);
  const double start = wall_time_seconds();
  const int opened = ::open(file.c_str(), O_RDONLY);
  const auto size = static_cast<std::size_t>(std::filesystem::file_size(file));
  void* const mapped = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, opened, 0);
  if (mapped == MAP_FAILED) return {{"error", "the file cannot be mapped"}};
  const std::uint64_t hash =
      test::golden_hash({static_cast<const std::byte*>(mapped), size / 8 * 8});
  const double read = wall_time_seconds();
  embree.build();
  const double built = wall_time_seconds();
  ::munmap(mapped, size);
  ::close(opened);
  return {{"read_seconds", read - start},
          {"build_seconds", built - read},
          {"peak_mib", memory_mib("VmHWM")},
          {"file_hash", std::to_string(hash)}};
}

bool make_file(const std::filesystem::path& file, unsigned smaller) {
  if (std::filesystem::exists(file)) return true;
  demo::DemoScene scene;
  if (file.stem().string().starts_with("terrain")) {
    scene = demo::terrain(10'000'000 / smaller);
  } else {
    const std::uint32_t side = smaller > 1 ? 30 : 100;
    for (std::uint32_t i = 0; i < side * side; ++i) {
      demo::DemoScene ball = demo::sphere(2000, i + 1);
      // A seed may draw the same ball again; no two have this size.
      for (float& x : ball.meshes[0].positions) x *= 1.0f + static_cast<float>(i) * 0x1p-20f;
      demo::DemoNode node;
      node.mesh = static_cast<int>(i);
      node.parent_from_node.m[0][3] = 3.0 * (i % side);
      const auto row = i / side;
      node.parent_from_node.m[2][3] = 3.0 * row;
      scene.meshes.push_back(std::move(ball.meshes[0]));
      scene.nodes.push_back(std::move(node));
    }
  }
  const std::vector<std::byte> glb = demo::write_glb(scene);
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(glb.data()), static_cast<std::streamsize>(glb.size()));
  return out.good();
}

bool settle_file(const std::filesystem::path& file) {
  const int opened = ::open(file.c_str(), O_RDONLY);
  if (opened < 0) return false;
  ::fsync(opened);
  std::vector<char> piece(1u << 20);
  ssize_t count = 0;
  while ((count = ::read(opened, piece.data(), piece.size())) > 0) {
  }
  ::close(opened);
  return count == 0;
}

}  // namespace sightline::bench
