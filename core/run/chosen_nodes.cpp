#include "core/run/chosen_nodes.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <optional>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "core/query/similar_names.h"
#include "core/run/unmatched_names.h"

namespace sightline {

namespace {

/// Whether any of the patterns matches a text, and which patterns match none. The result for a text
/// is remembered: a scene may have a hundred thousand nodes of one name.
class AnyGlob {
 public:
  AnyGlob(const std::vector<std::string>& patterns, std::size_t texts, DeadlineWatch& watch)
      : patterns_(patterns),
        watch_(watch),
        known_(slots_for(texts)),
        found_(patterns.size(), false),
        unfound_(patterns.size()) {}

  /// False also where the watch has passed.
  bool matches(std::string_view text) {
    const std::size_t hash = std::hash<std::string_view>()(text);
    // What takes the same slot takes its place: the table is bounded, and most names are few.
    Known& known = known_[hash & (known_.size() - 1)];
    if (!known.is_set || known.hash != hash || known.text != text)
      known = {text, hash, try_all(text), true};
    // To hash and to compare read sixteen bytes and more in the time of a step.
    watch_.passed(1 + text.size() / 16);
    return known.is_match;
  }
  /// Whether some pattern has matched nothing so far.
  bool seeks() const { return unfound_ > 0; }
  bool has_found(std::size_t pattern) const { return found_[pattern]; }
  std::size_t unfound() const { return unfound_; }

  static std::uint64_t bytes_for(std::size_t texts) { return slots_for(texts) * sizeof(Known); }

 private:
  struct Known {
    std::string_view text = {};
    std::size_t hash = 0;
    bool is_match = false, is_set = false;
  };
  static std::size_t slots_for(std::size_t texts) {
    constexpr std::size_t kMost = 32 << 10;
    return std::bit_ceil(std::clamp<std::size_t>(2 * std::min(texts, kMost), 1, kMost));
  }
  bool try_all(std::string_view text) {
    bool is_match = false;
    for (std::size_t i = 0; i < patterns_.size(); ++i) {
      // After a match only patterns without one are of interest.
      if (is_match && (found_[i] || !seeks())) continue;
      if (!glob_matches(patterns_[i], text, watch_)) continue;
      is_match = true;
      if (!found_[i]) --unfound_;
      found_[i] = true;
    }
    return is_match;
  }

  const std::vector<std::string>& patterns_;
  DeadlineWatch& watch_;
  std::vector<Known> known_;
  std::vector<bool> found_;
  std::size_t unfound_;
};

/// One list of patterns of a choice, and the names that they were held against.
struct PatternList {
  const std::vector<std::string>& patterns;
  std::string pointer;  ///< of the list
  std::string_view of;  ///< "node" or "material"
  std::size_t names;
  std::function<std::string_view(std::size_t)> name_at;
};

/// Steps of the search for similar names, for all patterns of a list in total.
constexpr std::uint64_t kMostSteps = std::uint64_t{2} << 20;

Status tell_unmatched(const PatternList& list, const AnyGlob& globs, DeadlineWatch& watch,
                      SelectionWarnings* warnings) {
  for (std::size_t i = 0; globs.seeks() && i < list.patterns.size(); ++i) {
    if (globs.has_found(i)) continue;
    const std::string& pattern = list.patterns[i];
    std::string message = "no " + std::string(list.of) + " has a name like \"" + pattern + "\"";
    message +=
        similar_names_text(pattern, list.names, list.name_at, kMostSteps / globs.unfound(), watch);
    if (watch.passed()) return watch.error();
    Status status = tell({list.pointer + "/" + std::to_string(i), std::move(message)}, warnings);
    if (!status) return status;
  }
  return success();
}

/// Marks what is named by number. Errors: FILTER_NODE_UNKNOWN.
Status choose_numbers(const SceneDescription& scene, const std::vector<std::uint32_t>& nodes,
                      const std::string& key, DeadlineWatch& watch, ChosenNodes& chosen) {
  // By the numbers of the question, not of the scene: that may have a million nodes.
  std::unordered_set<std::uint32_t> asked(nodes.begin(), nodes.end());
  std::unordered_set<std::uint32_t> found;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (watch.passed()) return watch.error();
    if (scene.nodes[i].removed || !asked.contains(scene.nodes[i].file_node)) continue;
    chosen.node[i] = 1;
    found.insert(scene.nodes[i].file_node);
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (found.contains(nodes[i])) continue;
    return Error{ErrorKind::kInvalid, "FILTER_NODE_UNKNOWN",
                 "the loaded scene has no node " + std::to_string(nodes[i]),
                 "/" + key + "/nodes/" + std::to_string(i)};
  }
  return success();
}

/// Marks what is named by a pattern, and all that is below a marked node.
Status choose_names(const SceneDescription& scene, const TriangleChoice& choice,
                    const std::string& key, DeadlineWatch& watch, ChosenNodes& chosen,
                    SelectionWarnings* warnings) {
  std::optional<AnyGlob> names;
  if (choice.names) names.emplace(*choice.names, scene.nodes.size(), watch);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    // Parents stand before their children.
    const Node& node = scene.nodes[i];
    const bool is_below = node.parent != kNone && chosen.node[node.parent] != 0;
    const bool is_named =
        names && !node.removed && (!is_below || names->seeks()) && names->matches(node.name);
    if (is_below || is_named) chosen.node[i] = 1;
    if (watch.passed()) return watch.error();
  }
  if (!names) return success();
  const auto name_at = [&](std::size_t i) -> std::string_view { return scene.nodes[i].name; };
  return tell_unmatched({*choice.names, "/" + key + "/names", "node", scene.nodes.size(), name_at},
                        *names, watch, warnings);
}

Status choose_materials(const SceneDescription& scene, const std::vector<std::string>& patterns,
                        const std::string& key, DeadlineWatch& watch, ChosenNodes& chosen,
                        SelectionWarnings* warnings) {
  const std::size_t count = scene.materials.size();
  AnyGlob materials(patterns, count, watch);
  for (std::size_t i = 0; i < count; ++i) {
    chosen.material[i] = materials.matches(scene.materials[i].name) ? 1 : 0;
    if (watch.passed()) return watch.error();
  }
  const auto name_at = [&](std::size_t i) -> std::string_view { return scene.materials[i].name; };
  return tell_unmatched({patterns, "/" + key + "/materials", "material", count, name_at}, materials,
                        watch, warnings);
}

/// Retains the named triangles that the other lists have. Errors: TRIANGLE_UNKNOWN.
Status choose_triangles(const Scene& scene, const std::vector<TriangleName>& names,
                        const std::string& key, DeadlineWatch& watch, ChosenNodes& chosen) {
  const SceneDescription& description = scene.description();
  std::vector<TriangleId>& triangles = chosen.triangles.emplace();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (watch.passed()) return watch.error();
    const auto id = scene.find_triangle(names[i]);
    if (!id) {
      return Error{ErrorKind::kInvalid, "TRIANGLE_UNKNOWN",
                   "the scene has no triangle with this instance, primitive and triangle",
                   "/" + key + "/triangles/" + std::to_string(i)};
    }
    const Instance& instance = description.instances[id->instance];
    const auto& primitives = description.meshes[instance.mesh]->primitives;
    if (chosen.holds(instance, primitives[scene.primitive_of(*id)].material))
      triangles.push_back(*id);
  }
  std::sort(triangles.begin(), triangles.end());
  triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
  return success();
}

bool has_empty_list(const TriangleChoice& choice) {
  return (choice.nodes && choice.nodes->empty()) || (choice.names && choice.names->empty()) ||
         (choice.materials && choice.materials->empty()) ||
         (choice.triangles && choice.triangles->empty());
}

/// Nodes without triangles, or with other materials than the named ones, match as names do. But
/// both lists choose nothing.
Status tell_without_triangles(const SceneDescription& scene, const ChosenNodes& chosen,
                              const std::string& key, DeadlineWatch& watch,
                              SelectionWarnings* warnings) {
  if (chosen.triangles && !chosen.triangles->empty()) return success();
  for (const Instance& instance : scene.instances) {
    if (chosen.triangles) break;
    const auto& primitives = scene.meshes[instance.mesh]->primitives;
    for (const Primitive& primitive : primitives)
      if (chosen.holds(instance, primitive.material)) return success();
    if (watch.passed(1 + primitives.size())) return watch.error();
  }
  return tell({"/" + key,
               "what is named here has no triangles, or none with a material that is named here"},
              warnings);
}

}  // namespace

Result<ChosenNodes> choose(const Scene& whole, const TriangleChoice& choice, const std::string& key,
                           DeadlineWatch& watch, SelectionWarnings* warnings) {
  const SceneDescription& scene = whole.description();
  const std::size_t told = warnings != nullptr ? warnings->size() : 0;
  ChosenNodes chosen;
  chosen.node.assign(scene.nodes.size(), choice.nodes || choice.names ? 0 : 1);
  chosen.material.assign(scene.materials.size() + 1, choice.materials ? 0 : 1);
  Status status = success();
  if (choice.nodes) status = choose_numbers(scene, *choice.nodes, key, watch, chosen);
  if (status) status = choose_names(scene, choice, key, watch, chosen, warnings);
  if (status && choice.materials)
    status = choose_materials(scene, *choice.materials, key, watch, chosen, warnings);
  if (status && choice.triangles)
    status = choose_triangles(whole, *choice.triangles, key, watch, chosen);
  const bool has_told = warnings != nullptr && warnings->size() > told;
  if (status && !has_told && !has_empty_list(choice))
    status = tell_without_triangles(scene, chosen, key, watch, warnings);
  if (!status) return std::move(status).error();
  return chosen;
}

std::uint64_t choosing_bytes(const SceneDescription& scene, const TriangleChoice& choice) {
  constexpr std::uint64_t kAskedBytes = 64;      // in two sets
  constexpr std::uint64_t kWarningBytes = 2048;  // of a pattern, three names and both as JSON
  std::uint64_t bytes = scene.nodes.size() + scene.materials.size() + 1 + kWarningBytes;
  if (choice.nodes) bytes += choice.nodes->size() * kAskedBytes;
  if (choice.triangles) bytes += choice.triangles->size() * 2 * sizeof(TriangleId);
  if (choice.names)
    bytes += AnyGlob::bytes_for(scene.nodes.size()) + choice.names->size() * kWarningBytes;
  if (choice.materials)
    bytes += AnyGlob::bytes_for(scene.materials.size()) + choice.materials->size() * kWarningBytes;
  return bytes;
}

}  // namespace sightline
