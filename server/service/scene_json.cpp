#include "server/service/scene_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kWarnings = 100;

std::string text_of(const Json& document) {
  // Names come from files; what is not UTF-8 in them is replaced.
  return document.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json vector_of(const Vec3d& v) { return Json::array({v.x, v.y, v.z}); }

Json reason_of(const Error& error) { return {{"code", error.code}, {"detail", error.message}}; }

void add_progress(Json& document, SceneState state, const Progress::Reading& progress) {
  if (state != SceneState::kLoading) return;
  document["stage"] = progress.stage;
  document["progress"] = nullptr;
  if (progress.percent) document["progress"] = *progress.percent;
}

Json summary_of(const StoredScene& scene) {
  Json document;
  document["id"] = scene.id;
  document["state"] = scene_state_name(scene.state);
  add_progress(document, scene.state, scene.progress);
  if (scene.failure) document["reason"] = reason_of(*scene.failure);
  if (scene.revision > 0) document["revision"] = scene.revision;
  if (!scene.sha256.empty()) {
    document["sha256"] = scene.sha256;
    document["bytes"] = scene.bytes;
  }
  if (scene.chosen) document["scene"] = *scene.chosen;
  document["persistent"] = scene.persistent;
  if (scene.scene) document["triangles"] = scene.scene->instanced_triangle_count();
  if (const auto& update = scene.update) {
    Json& next = document["update"];
    next["state"] = scene_state_name(update->state);
    add_progress(next, update->state, update->progress);
    if (update->failure) next["reason"] = reason_of(*update->failure);
  }
  return document;
}

}  // namespace

std::uint64_t bytes_of_scene(const StoredScene& stored) {
  // As it is, in the document, and as text, where a control character takes six bytes.
  constexpr std::uint64_t kRest = 8 << 10, kPerByte = 7;
  if (!stored.scene) return kRest;
  const SceneDescription& description = stored.scene->description();
  std::uint64_t bytes = description.name.size();
  for (std::size_t i = 0; i < std::min(description.warnings.size(), kWarnings); ++i) {
    bytes += description.warnings[i].size();
  }
  return kRest + kPerByte * bytes;
}

std::string encode_scene(const StoredScene& stored) {
  Json document = summary_of(stored);
  if (!stored.scene) return text_of(document);
  document.erase("triangles");
  const Scene& scene = *stored.scene;
  const SceneDescription& description = scene.description();
  document["name"] = description.name;
  document["counts"] = {{"nodes", scene.counts().nodes},
                        {"instances", scene.counts().instances},
                        {"meshes", scene.counts().meshes},
                        {"materials", description.materials.size()},
                        {"triangles", scene.instanced_triangle_count()},
                        {"unique_triangles", scene.unique_triangle_count()},
                        {"skipped_primitives", description.counts.skipped_primitives},
                        {"nonfinite_triangles", description.counts.nonfinite_triangles},
                        {"degenerate_triangles", description.counts.degenerate_triangles},
                        {"bytes_touched", description.counts.bytes_touched}};
  document["bounds"] = nullptr;
  if (!scene.bounds().empty()) {
    document["bounds"] = {{"min", vector_of(scene.bounds().min)},
                          {"max", vector_of(scene.bounds().max)}};
  }
  const auto& warnings = description.warnings;
  document["warnings"] = Json::array();
  for (std::size_t i = 0; i < std::min(warnings.size(), kWarnings); ++i) {
    document["warnings"].push_back(warnings[i]);
  }
  if (warnings.size() > kWarnings) document["warnings_total"] = warnings.size();
  return text_of(document);
}

std::string encode_scene_summary(const StoredScene& scene) { return text_of(summary_of(scene)); }

std::string encode_scene_list(const std::vector<SceneSnapshot>& scenes) {
  Json list = Json::array();
  for (const SceneSnapshot& scene : scenes) list.push_back(summary_of(*scene));
  return text_of({{"scenes", std::move(list)}});
}

}  // namespace sightline
