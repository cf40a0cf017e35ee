#include "server/service/tree_json.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <unordered_set>

#include "core/run/kept_sides.h"
#include "core/trace/explain.h"
#include "core/trace/tree_report.h"
#include "proto/json_writer.h"

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
  out.raw(",\"miss\":[");
  out.raw(kAxes[met.apart[0]]);
  if (met.apart[0] != met.apart[1]) {
    out.raw(',');
    out.raw(kAxes[met.apart[1]]);
  }
  out.raw(']');
}

/// Which part of a filter leaves a triangle out that a ray meets.
class FilterParts {
 public:
  FilterParts(const Scene& scene, const KeptSides* kept) : scene_(scene), kept_(kept) {}
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
    return kept_ != nullptr && !chooses(*kept_, id) ? "mask" : "cull";
  }

 private:
  bool chooses(const KeptSides& kept, TriangleId id) const {
    return kept.sides[kept.first[id.instance] + scene_.primitive_of(id)] != 0;
  }

  const Scene& scene_;
  const KeptSides* kept_;
  std::optional<KeptSides> include_, exclude_;
};

/// Begins an object.
void write_id(JsonWriter& out, const Scene& scene, TriangleId id) {
  const SceneDescription& description = scene.description();
  const Mesh& mesh = *description.meshes[description.instances[id.instance].mesh];
  const Primitive& primitive = mesh.primitives[scene.primitive_of(id)];
  out.raw("{\"instance\":");
  out.number(id.instance);
  out.raw(",\"primitive\":");
  out.number(primitive.file_primitive);
  out.raw(",\"triangle\":");
  out.number(id.triangle - primitive.first_triangle);
}

void write_seen(JsonWriter& out, const Scene& scene, const FilterParts& filter,
                const ExplainedTriangle& seen) {
  write_id(out, scene, seen.id);
  const bool met = seen.verdict != ExplainedTriangle::Verdict::kMissed;
  out.raw(!met                                                    ? ",\"verdict\":\"missed\""
          : seen.verdict == ExplainedTriangle::Verdict::kFiltered ? ",\"verdict\":\"filtered\""
                                                                  : ",\"verdict\":\"hit\"");
  if (seen.verdict == ExplainedTriangle::Verdict::kFiltered) {
    out.raw(",\"by\":\"");
    out.raw(filter.name_of(seen.id));
    out.raw('"');
  }
  if (met) {
    out.raw(",\"t\":");
    out.number(seen.t);
  }
  out.raw('}');
}

void write_visit(JsonWriter& out, const Scene& scene, const FilterParts& filter,
                 const ExplainedBox& box) {
  out.raw("{\"parent\":");
  out.raw(box.parent < 0 ? "null" : std::to_string(box.parent));
  out.raw(",\"leaf\":");
  out.boolean(box.is_leaf);
  out.raw(box.in_mesh ? ",\"space\":\"mesh\"" : ",\"space\":\"world\"");
  out.raw(",\"min\":");
  out.vector(box.box.min.x, box.box.min.y, box.box.min.z);
  out.raw(",\"max\":");
  out.vector(box.box.max.x, box.box.max.y, box.box.max.z);
  out.raw(",\"verdict\":\"");
  const std::string_view verdict = verdict_of(box);
  out.raw(verdict);
  out.raw('"');
  if (verdict == "missed") {
    write_slabs(out, box.met);
  } else {
    out.raw(",\"t_enter\":");
    out.number(box.met.t_enter);
    out.raw(",\"t_exit\":");
    out.number(box.met.t_exit);
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
  const auto count = [&](std::string_view before, std::uint64_t number) {
    out.raw(before);
    out.number(number);
  };
  const auto ratio = [&](std::string_view before, double number) {
    out.raw(before);
    out.number(number);
  };
  count("{\"placements\":", placements);
  count(",\"nodes\":", report.nodes);
  count(",\"leaves\":", report.leaves);
  count(",\"blocks\":", report.blocks);
  count(",\"triangles\":", report.triangles);
  count(",\"depth\":", report.depth);
  count(",\"shallowest\":", report.shallowest);
  ratio(",\"mean_depth\":", report.mean_depth);
  ratio(",\"arity\":", report.arity);
  ratio(",\"sah_cost\":", report.sah_cost);
  ratio(",\"overlap\":", report.overlap);
  out.raw(",\"contained\":");
  out.boolean(report.contained);
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
  if (name.empty()) {
    out.raw("null");
  } else {
    out.string(name);
  }
  out.raw(",\"distance\":");
  out.number(miss->distance.low * 0.5 + miss->distance.high * 0.5);
  out.raw('}');
  return out.take();
}

Result<std::string> encode_explanation(const Scene& scene, const Ray& ray, const HitFilter& filter,
                                       const KeptSides* kept, const Deadline& deadline,
                                       const ReserveBytes& reserve) {
  FilterParts parts(scene, kept);
  if (Status status = parts.choose(filter, deadline, reserve); !status)
    return std::move(status).error();
  const SceneView view(scene);
  const Explanation explanation = explain_ray(view, ray, kept);
  JsonWriter out(64 + explanation.boxes.size() * 200);
  out.raw("{\"boxes\":[");
  for (std::size_t i = 0; i < explanation.boxes.size(); ++i) {
    if (i > 0) out.raw(',');
    write_visit(out, scene, parts, explanation.boxes[i]);
  }
  out.raw("],\"truncated\":");
  out.boolean(explanation.truncated);
  out.raw('}');
  return out.take();
}

std::string encode_trees(const Scene& scene) {
  const SceneView view(scene);
  const SceneTree& trees = view.tree();
  JsonWriter out(256);
  out.raw("{\"complete\":");
  out.boolean(trees.complete());
  out.raw(",\"pending\":");
  out.number(trees.pending);
  out.raw(",\"trees\":[");
  std::unordered_set<std::uint32_t> told;
  for (std::uint32_t entry = 0; entry < trees.entries && told.size() < kMostTrees; ++entry) {
    const std::uint32_t tree = trees.placements[entry].tree;
    if (trees.is_pending(tree) || !told.insert(tree).second) continue;
    const auto uses =
        std::count_if(trees.placements.begin(), trees.placements.end(),
                      [&](const Placement& placement) { return placement.tree == tree; });
    if (told.size() > 1) out.raw(',');
    write_report(out, report_tree(view, entry), static_cast<std::uint32_t>(uses));
  }
  out.raw("],\"total\":");
  out.number(std::uint64_t{trees.trees.size()});
  out.raw(",\"top\":");
  if (trees.entries < 2) {
    out.raw("null");
  } else {
    write_report(out, report_top_tree(view), trees.entries);
  }
  out.raw('}');
  return out.take();
}

}  // namespace sightline
