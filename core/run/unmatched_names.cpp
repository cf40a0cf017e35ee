#include "core/run/unmatched_names.h"

#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/watch.h"
#include "core/query/similar_names.h"

namespace sightline {

Status tell(SelectionWarning warning, SelectionWarnings* warnings) {
  if (warnings == nullptr) {
    return Error{ErrorKind::kInvalid, std::string(kSelectionEmpty), std::move(warning.message),
                 std::move(warning.pointer)};
  }
  warnings->push_back(std::move(warning));
  return success();
}

Status tell_unknown_fields(const SceneDescription& scene, std::span<const std::string> names,
                           const Deadline& deadline, SelectionWarnings* warnings) {
  constexpr std::uint64_t kMostSimilarSteps = 100'000;
  if (names.empty()) return success();
  std::vector<std::string_view> known;
  for (const NamedAttribute& attribute : scene.named_attributes) {
    if (attribute.is_in_scene) known.push_back(attribute.name);
  }
  DeadlineWatch watch(deadline);
  for (const std::string& name : names) {
    const auto found = find_named_attribute(scene, name);
    if (found && scene.named_attributes[named_index(*found)].is_in_scene) continue;
    std::string message = "no primitive has an attribute \"" + name + "\"";
    message += similar_names_text(
        name, known.size(), [&](std::size_t i) { return known[i]; }, kMostSimilarSteps, watch);
    if (watch.passed()) return watch.error();
    Status status = tell({"/fields", std::move(message)}, warnings);
    if (!status) return status;
  }
  return success();
}

}  // namespace sightline
