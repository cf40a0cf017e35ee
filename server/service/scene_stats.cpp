#include "server/service/scene_stats.h"

#include <nlohmann/json.hpp>

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Json object_of(const NamedCounts& counts) {
  Json object = Json::object();
  for (const auto& [name, count] : counts) object[name] = count;
  return object;
}

}  // namespace

NamedCounts touched_counts(const Scene& scene) {
  const TouchedBytes& touched = scene.description().counts.touched;
  return {{"json", touched.json},
          {"positions", touched.positions},
          {"indices", touched.indices},
          {"poses", touched.poses},
          {"placements", touched.placements},
          {"attributes", touched.attributes + scene.attribute_bytes().load()},
          {"compressed", touched.compressed},
          {"others", touched.others}};
}

NamedCounts skipped_counts(const Scene& scene) {
  const ImportCounts& counts = scene.description().counts;
  const ImportSkips& skipped = counts.skipped;
  return {{"scenes", skipped.scenes},
          {"nodes", skipped.nodes},
          {"meshes", skipped.meshes},
          {"images", skipped.images},
          {"animations", skipped.animations},
          {"attributes", skipped.attributes},
          {"primitives", counts.skipped_primitives}};
}

NamedCounts tree_counts(const Scene& scene) {
  const TreeStats stats = scene.trees().stats();
  return {{"meshes_total", stats.meshes_total},   {"meshes_built", stats.meshes_built},
          {"trees_built", stats.trees_built},     {"trees_kept", stats.trees_kept},
          {"meshes_split", stats.meshes_split},   {"full_builds", stats.full_builds},
          {"evictions", stats.evictions},         {"cache_hits", stats.cache_hits},
          {"cache_rejects", stats.cache_rejects}, {"queries_waited", stats.queries_waited},
          {"tree_bytes", stats.tree_bytes},       {"geometry_bytes", stats.geometry_bytes}};
}

std::string encode_stats(const StoredScene& stored) {
  const Scene& scene = *stored.scene;
  const SceneDescription& description = scene.description();
  Json document;
  document["id"] = stored.id;
  document["revision"] = stored.revision;
  document["counts"] = {{"nodes", scene.counts().nodes},
                        {"instances", scene.counts().instances},
                        {"meshes", scene.counts().meshes},
                        {"triangles", scene.instanced_triangle_count()},
                        {"unique_triangles", scene.unique_triangle_count()},
                        {"posed_meshes", description.counts.posed_meshes},
                        {"nonfinite_triangles", description.counts.nonfinite_triangles},
                        {"degenerate_triangles", description.counts.degenerate_triangles},
                        {"warnings", description.warnings.size()}};
  document["bytes"] = {
      {"files", description.counts.file_bytes},
      {"touched", description.counts.bytes_touched + scene.attribute_bytes().load()},
      {"by_kind", object_of(touched_counts(scene))}};
  document["skipped"] = object_of(skipped_counts(scene));
  document["trees"] = object_of(tree_counts(scene));
  document["trees"]["complete"] = scene.trees().stats().complete;
  return document.dump() + "\n";
}

}  // namespace sightline
