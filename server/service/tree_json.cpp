#include "server/service/tree_json.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <unordered_set>

#include "core/run/resolved_filter.h"
#include "core/trace/inspect/explain.h"
#include "core/trace/inspect/tree_levels.h"
#include "core/trace/inspect/tree_report.h"
#include "proto/json/json_parts.h"

namespace sightline {
namespace {

constexpr std::size_t kMostTrees = 100;

std::string_view verdict_of(const ExplainedBox& box) {
  switch (box.met.outcome) {
    case RayBoxOutcome::kHit:
      return box.behind_hit ? "farther" : "entered";
    case RayBoxOutcome::kBehind:
      return "behind";
    case RayBoxOutcome::kBeyond:
      return "beyond";
    default:
      return "missed";
  }
}

void write_slabs(JsonWriter& out, const RayBoxAnswer& met) {
  constexpr std::array<std::string_view, 3> kAxes{"\"x\"", "\"y\"", "\"z\""};
  write(out, ",\"miss\":[", kAxes[met.apart[0]]);
  if (met.apart[0] != met.apart[1]) write(out, ',', kAxes[met.apart[1]]);
  out.raw(']');
}

/// Which part of a filter leaves a triangle out that a ray meets.
class FilterParts {
 public:
  FilterParts(const Scene& scene, const ResolvedFilter* resolved)
      : scene_(scene), resolved_(resolved) {}
  /// To be called first. Errors: those of chosen_sides.
  Status choose(const HitFilter& filter, const Deadline& deadline, const ReserveBytes& reserve) {
    for (const auto& [choice, sides, key] : {std::tuple{&filter.include, &include_, "include"},
                                             std::tuple{&filter.exclude, &exclude_, "exclude"}}) {
      if (!*choice) continue;
      // The answer that is explained has them already.
      SelectionWarnings told;
      auto chosen = chosen_sides(scene_, **choice, key, deadline, reserve, &told);
      if (!chosen) return std::move(chosen).error();
      *sides = std::move(*chosen);
    }
    return success();
  }
  std::string_view name_of(TriangleId id) const {
    if (include_ && !chooses(*include_, id)) return "include";
    if (exclude_ && chooses(*exclude_, id)) return "exclude";
    // Culling leaves a side of everything.
    return resolved_ != nullptr && !chooses(*resolved_, id) ? "mask" : "cull";
  }

 private:
  bool chooses(const ResolvedFilter& resolved, TriangleId id) const {
    return resolved.sides[resolved.first[id.instance] + scene_.primitive_of(id)] != 0;
  }

  const Scene& scene_;
  const ResolvedFilter* resolved_;
  std::optional<ResolvedFilter> include_, exclude_;
};

/// Begins an object.
void write_id(JsonWriter& out, const Scene& scene, TriangleId id) {
  const SceneDescription& description = scene.description();
  const Mesh& mesh = *description.meshes[description.instances[id.instance].mesh];
  const Primitive& primitive = mesh.primitives[scene.primitive_of(id)];
  write(out, "{\"instance\":", id.instance, ",\"primitive\":", primitive.file_primitive,
        ",\"triangle\":", id.triangle - primitive.first_triangle);
}

void write_seen(JsonWriter& out, const Scene& scene, const FilterParts& filter,
                const ExplainedTriangle& seen) {
  write_id(out, scene, seen.id);
  const bool met = seen.verdict != ExplainedTriangle::Verdict::kMissed;
  out.raw(!met                                                    ? ",\"verdict\":\"missed\""
          : seen.verdict == ExplainedTriangle::Verdict::kFiltered ? ",\"verdict\":\"filtered\""
                                                                  : ",\"verdict\":\"hit\"");
  if (seen.verdict == ExplainedTriangle::Verdict::kFiltered) {
    write(out, ",\"by\":\"", filter.name_of(seen.id), '"');
  }
  if (met) {
    write(out, ",\"t\":", seen.t);
  }
  out.raw('}');
}

void write_visit(JsonWriter& out, const Scene& scene, const FilterParts& filter,
                 const ExplainedBox& box) {
  write(out, "{\"parent\":", box.parent < 0 ? "null" : std::to_string(box.parent),
        ",\"leaf\":", box.is_leaf,
        box.instance != kNone ? ",\"space\":\"mesh\"" : ",\"space\":\"world\"",
        ",\"min\":", box.box.min, ",\"max\":", box.box.max);
  if (box.instance != kNone) {
    const Affine& matrix = scene.description().instances[box.instance].world_from_mesh;
    const Vec3d &min = box.box.min, &max = box.box.max;
    write(out, ",\"instance\":", box.instance, ",\"corners\":[", matrix.apply(min), ',',
          matrix.apply(Vec3d{max.x, min.y, min.z}), ',', matrix.apply(Vec3d{min.x, max.y, min.z}),
          ',', matrix.apply(Vec3d{min.x, min.y, max.z}), ']');
  }
  out.raw(",\"verdict\":\"");
  const std::string_view verdict = verdict_of(box);
  write(out, verdict, '"');
  if (verdict == "missed") {
    write_slabs(out, box.met);
  } else {
    write(out, ",\"t_enter\":", box.met.t_enter, ",\"t_exit\":", box.met.t_exit);
  }
  if (box.is_leaf && verdict == "entered" && !box.triangles.empty()) {
    char before = '[';
    out.raw(",\"triangles\":");
    for (const ExplainedTriangle& seen : box.triangles) {
      out.raw(before);
      write_seen(out, scene, filter, seen);
      before = ',';
    }
    out.raw(']');
  }
  out.raw('}');
}

void write_report(JsonWriter& out, const TreeReport& report, std::uint32_t placements) {
  write(out, "{\"placements\":", placements, ",\"nodes\":", report.nodes,
        ",\"leaves\":", report.leaves, ",\"blocks\":", report.blocks,
        ",\"triangles\":", report.triangles, ",\"depth\":", report.depth,
        ",\"shallowest\":", report.shallowest, ",\"mean_depth\":", report.mean_depth,
        ",\"arity\":", report.arity, ",\"sah_cost\":", report.sah_cost,
        ",\"overlap\":", report.overlap, ",\"contained\":", report.contained, '}');
}

void write_level(JsonWriter& out, const TreeLevel& level) {
  out.raw(",\"level\":{\"boxes\":[");
  for (std::size_t i = 0; i < level.boxes.size(); ++i) {
    const auto& [box, is_leaf] = level.boxes[i];
    out.raw(i > 0 ? ",{\"min\":" : "{\"min\":");
    out.vector(box.min.x, box.min.y, box.min.z);
    out.raw(",\"max\":");
    out.vector(box.max.x, box.max.y, box.max.z);
    out.raw(",\"leaf\":");
    out.boolean(is_leaf);
    out.raw('}');
  }
  out.raw("],\"truncated\":");
  out.boolean(level.truncated);
  out.raw('}');
}

}  // namespace

std::string encode_nearest_miss(const Scene& scene, const std::optional<NearestMiss>& miss) {
  if (!miss) return "null";
  JsonWriter out(128);
  write_id(out, scene, miss->id);
  const SceneDescription& description = scene.description();
  const std::string& name = description.nodes[description.instances[miss->id.instance].node].name;
  out.raw(",\"node\":");
  out.name(name);
  write(out, ",\"distance\":", miss->distance.low * 0.5 + miss->distance.high * 0.5, '}');
  return out.take();
}

Result<std::string> encode_explanation(const Scene& scene, const Ray& ray, const HitFilter& filter,
                                       const ResolvedFilter* resolved, const Deadline& deadline,
                                       const ReserveBytes& reserve) {
  FilterParts parts(scene, resolved);
  if (Status status = parts.choose(filter, deadline, reserve); !status)
    return std::move(status).error();
  const SceneView view(scene);
  const Explanation explanation = explain_ray(view, ray, resolved);
  JsonWriter out(64 + explanation.boxes.size() * 200);
  out.raw("{\"boxes\":[");
  for (std::size_t i = 0; i < explanation.boxes.size(); ++i) {
    if (i > 0) out.raw(',');
    write_visit(out, scene, parts, explanation.boxes[i]);
  }
  write(out, "],\"truncated\":", explanation.truncated, '}');
  return out.take();
}

std::string encode_trees(const Scene& scene, std::optional<std::uint32_t> level) {
  const SceneView view(scene);
  const SceneTree& trees = view.tree();
  JsonWriter out(256);
  write(out, "{\"complete\":", trees.complete(), ",\"pending\":", trees.unbuilt_count,
        ",\"trees\":[");
  std::unordered_set<std::uint32_t> told;
  for (std::uint32_t entry = 0; entry < trees.entries && told.size() < kMostTrees; ++entry) {
    const std::uint32_t tree = trees.placements[entry].tree;
    if (trees.is_unbuilt(tree) || !told.insert(tree).second) continue;
    const auto uses =
        std::count_if(trees.placements.begin(), trees.placements.end(),
                      [&](const Placement& placement) { return placement.tree == tree; });
    if (told.size() > 1) out.raw(',');
    write_report(out, report_tree(view, entry), static_cast<std::uint32_t>(uses));
  }
  write(out, "],\"total\":", std::uint64_t{trees.trees.size()}, ",\"top\":");
  if (trees.entries < 2) {
    out.raw("null");
  } else {
    write_report(out, report_top_tree(view), trees.entries);
  }
  if (level) write_level(out, boxes_of_level(view, *level, kMostLevelBoxes));
  out.raw('}');
  return out.take();
}

}  // namespace sightline
