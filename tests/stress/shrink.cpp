#include "tests/stress/shrink.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <limits>
#include <sstream>

#include "core/base/infinity.h"
#include "core/run/engine.h"
#include "tests/oracle/detail_check.h"
#include "tests/oracle/scene_oracle.h"
#include "tests/oracle/world_triangles.h"
#include "tests/support/float_text.h"

namespace sightline::stress {
namespace {

using test::hex;
using test::same_bits;
constexpr unsigned kSecondsForARay = 5;

std::string judge_here(const SceneDescription& description, const Ray& ray,
                       const std::string& kernel, Joining joining) {
  auto scene = Scene::build(description, TreeQuality::kHigh, joining);
  if (!scene) return "scene: " + scene.error().message;
  auto engine = Engine::create({1, kernel});
  if (!engine) return "engine: " + engine.error().message;
  const oracle::WorldTriangles triangles(**scene);
  const oracle::SceneOracle oracle(triangles.triangles);
  const auto truth = oracle.closest(ray);
  const auto list = oracle.all(ray);
  std::size_t once = 0;
  for (const auto& hit : list)
    once += oracle::crosses_when_moved(ray, triangles.triangles[hit.triangle]) ? 1u : 0u;

  const Deadline never = Deadline::never();
  for (const std::size_t copies : {std::size_t{1}, std::size_t{40}}) {
    RayBatch rays;
    for (std::size_t i = 0; i < copies; ++i) rays.push_back(ray);
    HitBatch hits;
    Column<std::uint8_t> any;
    Column<HitDetail> details;
    Column<std::uint64_t> counts, once_counts, totals;
    HitLists lists;
    constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
    for (const Status& s :
         {(*engine)->closest(**scene, rays, never, hits), (*engine)->any(**scene, rays, never, any),
          (*engine)->details(**scene, rays, hits, never, details),
          (*engine)->count(**scene, rays, Crossings::kEvery, never, counts),
          (*engine)->count(**scene, rays, Crossings::kOnce, never, once_counts),
          (*engine)->all(**scene, rays, {Crossings::kEvery, kAll, kAll}, never, lists, totals)}) {
      if (!s) return "engine: " + s.error().message;
    }
    for (std::size_t i = 0; i < copies; ++i) {
      if (hits.hit(i) != truth.has_value())
        return truth ? "false miss; exact t " + hex(truth->t_rounded)
                     : "false hit at " + hex(hits.t[i]);
      if (!same_bits(hits.t[i], truth ? truth->t_rounded : kInf))
        return "t " + hex(hits.t[i]) + ", exact " + hex(truth ? truth->t_rounded : kInf);
      if (truth && triangles.index(hits.id(i)) != truth->triangle) return "wrong primitive";
      if ((any[i] != 0) != truth.has_value()) return "any";
      if (counts[i] != list.size())
        return "count " + std::to_string(counts[i]) + ", exact " + std::to_string(list.size());
      if (once_counts[i] != once)
        return "once " + std::to_string(once_counts[i]) + ", exact " + std::to_string(once);
      if (totals[i] != list.size()) return "all";
      for (std::size_t k = 0; k < list.size(); ++k) {
        if (triangles.index(lists.hits.id(lists.first[i] + k)) != list[k].triangle ||
            !same_bits(lists.hits.t[lists.first[i] + k], list[k].t_rounded))
          return "all";
      }
      if (truth &&
          !check_detail(ray, triangles.triangles[truth->triangle], truth->t, details[i]).kept())
        return "detail";
    }
  }
  return {};
}

using Fault = std::string;

struct Shrinker {
  Ray ray;
  std::string kernel;
  Joining joining;
  Fault fault;

  bool still_wrong(const SceneDescription& scene) {
    const Fault now = fault_of(scene, ray, kernel, joining);
    if (now.empty()) return false;
    fault = now;
    return true;
  }

  /// Leaves out runs of `size`, half as long each time, while the rest is still wrong.
  template <class Without>
  void leave_out(std::size_t count, Without&& without) {
    for (std::size_t size = std::max<std::size_t>(1, count / 2); size > 0; size /= 2) {
      for (std::size_t first = 0; first < count;) {
        const std::size_t last = std::min(count, first + size);
        if (without(first, last)) {
          count -= last - first;
        } else {
          first = last;
        }
      }
    }
  }

  void run(SceneDescription& scene) {
    leave_out(scene.instances.size(), [&](std::size_t first, std::size_t last) {
      SceneDescription smaller = scene;
      smaller.instances.erase(smaller.instances.begin() + static_cast<std::ptrdiff_t>(first),
                              smaller.instances.begin() + static_cast<std::ptrdiff_t>(last));
      if (smaller.instances.empty() || !still_wrong(smaller)) return false;
      scene = smaller;
      return true;
    });
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
      leave_out(scene.meshes[m]->triangle_count(), [&](std::size_t first, std::size_t last) {
        auto mesh = std::make_shared<Mesh>(*scene.meshes[m]);
        UnsetColumn<std::uint32_t>& indices = mesh->indices.own();
        indices.erase(indices.begin() + static_cast<std::ptrdiff_t>(3 * first),
                      indices.begin() + static_cast<std::ptrdiff_t>(3 * last));
        if (mesh->indices.empty()) return false;
        mesh->primitives = {{0, mesh->triangle_count(), 0, 0xffffffffu}};
        SceneDescription smaller = scene;
        smaller.meshes[m] = mesh;
        if (!still_wrong(smaller)) return false;
        scene = smaller;
        return true;
      });
    }
  }
};

}  // namespace

std::string fault_of(const SceneDescription& scene, const Ray& ray, const std::string& kernel,
                     Joining joining) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return judge_here(scene, ray, kernel, joining);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    alarm(kSecondsForARay);  // an answer that never comes is a fault as well
    const std::string text = judge_here(scene, ray, kernel, joining);
    const auto written = write(ends[1], text.data(), text.size());
    _exit(written == static_cast<ssize_t>(text.size()) ? 0 : 1);
  }
  close(ends[1]);
  std::string text;
  std::array<char, 256> part{};
  for (ssize_t n = 0; (n = read(ends[0], part.data(), part.size())) > 0;)
    text.append(part.data(), static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFSIGNALED(status)) return std::string("crash: ") + strsignal(WTERMSIG(status));
  return text;
}

std::optional<SmallestCase> shrink(const Case& failing, const std::string& kernel,
                                   Joining joining) {
  for (std::size_t i = 0; i < failing.rays.size(); ++i) {
    for (const bool whole_line : {false, true}) {
      Ray ray = failing.rays[i];
      if (whole_line) {
        ray.tmin = -kInf;
        ray.tmax = kInf;
      }
      const std::string fault = fault_of(failing.scene, ray, kernel, joining);
      if (fault.empty()) continue;
      SmallestCase smallest{failing.scene, ray, fault};
      Shrinker shrinker{ray, kernel, joining, fault};
      shrinker.run(smallest.scene);
      smallest.fault = shrinker.fault;
      return smallest;
    }
  }
  return std::nullopt;
}

std::string describe(const SmallestCase& smallest) {
  const auto vector = [](const Vec3d& v) {
    return "{" + hex(v.x) + ", " + hex(v.y) + ", " + hex(v.z) + "}";
  };
  std::ostringstream out;
  const Ray& ray = smallest.ray;
  out << smallest.fault << "\nray {" << vector(ray.origin) << ", " << vector(ray.direction) << ", "
      << hex(ray.tmin) << ", " << hex(ray.tmax) << "}\n";
  for (const Instance& instance : smallest.scene.instances) {
    out << "placement";
    for (const auto& row : instance.world_from_mesh.m) {
      out << " {" << hex(row[0]);
      for (int k = 1; k < 4; ++k) out << ", " << hex(row[k]);
      out << "}";
    }
    out << "\n";
    const Mesh& mesh = *smallest.scene.meshes[instance.mesh];
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      out << "  triangle";
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3f& v = mesh.positions[mesh.indices[i + k]];
        out << " "
            << vector(
                   {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)});
      }
      out << "\n";
    }
  }
  return out.str();
}

}  // namespace sightline::stress
