#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/import/import.h"
#include "tests/support/data_folder.h"

// Every file of tests/data/hostile, with the manifest as the expectation.

namespace sightline {
namespace {

struct Outcome {
  std::string name;  ///< reject, load, load_warn or load_empty, as the manifest calls them
  std::string text;  ///< the error, or the first warning
  std::uint64_t triangles = 0;
};

/// Placed triangles whose corners are all finite: what the manifest calls kept.
std::uint64_t finite_triangles(const SceneDescription& scene) {
  std::uint64_t count = 0;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = *scene.meshes[instance.mesh];
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
      bool finite = true;
      for (std::uint32_t k = 0; k < 3; ++k) {
        const Vec3f& p = mesh.positions[mesh.indices[std::size_t{i} * 3 + k]];
        finite = finite && std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
      }
      count += finite ? 1 : 0;
    }
  }
  return count;
}

bool has_area(const SceneDescription& scene) {
  for (const auto& mesh : scene.meshes) {
    for (std::uint32_t i = 0; i < mesh->triangle_count(); ++i) {
      // Enough for these files: small integers, or far apart.
      double p[3][3];
      for (std::uint32_t k = 0; k < 3; ++k) {
        const Vec3f& v = mesh->positions[mesh->indices[std::size_t{i} * 3 + k]];
        for (int c = 0; c < 3; ++c) p[k][c] = static_cast<double>(v[c]);
      }
      for (int c = 0; c < 3; ++c) {
        const int d = (c + 1) % 3;
        const double cross =
            (p[1][c] - p[0][c]) * (p[2][d] - p[0][d]) - (p[1][d] - p[0][d]) * (p[2][c] - p[0][c]);
        if (std::isfinite(cross) && cross != 0) return true;
      }
    }
  }
  return false;
}

Outcome outcome_of(const std::filesystem::path& file) {
  const auto scene = import_file(file, {});
  if (!scene) return {"reject", scene.error().code + ": " + scene.error().message, 0};
  const std::string warning = scene->warnings.empty() ? "" : scene->warnings[0];
  const std::uint64_t triangles = finite_triangles(*scene);
  if (triangles == 0 || !has_area(*scene)) return {"load_empty", warning, triangles};
  const bool warned = !scene->warnings.empty() || scene->counts.skipped_primitives > 0;
  return {warned ? "load_warn" : "load", warning, triangles};
}

TEST(HostileFiles, end_as_the_manifest_allows) {
  const std::filesystem::path folder = test::test_data("hostile/cases");
  std::ifstream in(folder / "manifest.json");
  const nlohmann::json manifest = nlohmann::json::parse(in);
  EXPECT_EQ(manifest.size(), 147u);
  for (const auto& entry : manifest) {
    const auto name = entry["file"].get<std::string>();
    SCOPED_TRACE(name + ": " + entry["why"].get<std::string>());
    const Outcome outcome = outcome_of(folder / name);
    RecordProperty(name, outcome.name + " " + outcome.text);
    auto allowed = entry["also_ok"].get<std::vector<std::string>>();
    allowed.push_back(entry["expect"].get<std::string>());
    EXPECT_NE(std::find(allowed.begin(), allowed.end(), outcome.name), allowed.end())
        << outcome.name << " instead of " << entry["expect"] << " or " << entry["also_ok"] << "; "
        << outcome.text;
    if (outcome.name != "reject" && entry["triangles"].is_number()) {
      EXPECT_EQ(outcome.triangles, entry["triangles"].get<std::uint64_t>());
    }
    EXPECT_LT(outcome.text.size(), 400u) << "a message echoes the file";
    if (std::getenv("SHOW_OUTCOMES") != nullptr) {
      std::printf("%-40s %-10s %s\n", name.c_str(), outcome.name.c_str(), outcome.text.c_str());
    }
  }
}

}  // namespace
}  // namespace sightline
