#include "core/import/gltf/gltf_attributes.h"

namespace sightline::gltf {

using nlohmann::json;

void take_attributes(json& primitive, json* draco, const Counts& counts, std::size_t mesh,
                     std::size_t number, GltfDocument& document, const Place& at) {
  AttributeEntry entry;
  bool has_any = false;
  const auto warn = [&](JsonChecker& check) {
    const Error error = check.take();
    document.warnings.push_back(error.message + " and was left out");
  };
  json& attributes = primitive["attributes"];
  const Place list = at.member("attributes");
  for (std::size_t i = 0; i < kVertexAttributes; ++i) {
    const char* const name = kVertexAttributeNames[i];
    if (!attributes.contains(name)) continue;
    JsonChecker check;
    const auto accessor = check.reference(attributes, name, list, counts.accessors, "accessors");
    if (!check.good()) {
      warn(check);
      continue;
    }
    entry.accessor[i] = static_cast<int>(accessor.value_or(0));
    has_any = true;
    const auto compressed = draco != nullptr ? draco->find("attributes") : json::iterator();
    if (draco == nullptr || compressed == draco->end() || !compressed->is_object()) continue;
    const auto id = check.integer(*compressed, name, at.member("extensions"), 0xffffffffu);
    if (!check.good()) warn(check);
    if (id.has_value()) entry.draco[i] = static_cast<std::uint32_t>(*id);
  }
  if (!has_any) return;
  if (const auto targets = primitive.find("targets");
      targets != primitive.end() && targets->is_array()) {
    for (std::size_t k = 0; k < targets->size(); ++k) {
      json& target = (*targets)[k];
      std::array<int, kVertexAttributes>& moves = entry.targets.emplace_back();
      moves.fill(-1);
      for (std::size_t i = 0; i < kVertexAttributes; ++i) {
        const char* const name = kVertexAttributeNames[i];
        if (!target.is_object() || !target.contains(name)) continue;
        JsonChecker check;
        const auto accessor = check.reference(target, name, at.member("targets").element(k),
                                              counts.accessors, "accessors");
        if (check.good()) {
          moves[i] = static_cast<int>(accessor.value_or(0));
        } else {
          warn(check);
          moves[i] = AttributeEntry::kUnusable;
        }
      }
    }
  }
  document.attributes.emplace(std::make_pair(mesh, number), std::move(entry));
}

}  // namespace sightline::gltf
