#include "core/import/gltf/gltf_attributes.h"

#include <algorithm>

#include "core/import/input/refusal.h"
#include "core/query/attribute_name.h"

namespace sightline::gltf {

using nlohmann::json;

namespace {

/// Reads the attributes of one primitive.
class PrimitiveAttributesReader {
 public:
  PrimitiveAttributesReader(json& primitive, json* draco, const Counts& counts,
                            GltfDocument& document, const Place& at)
      : primitive_(primitive), draco_(draco), counts_(counts), document_(document), at_(at) {}

  std::vector<AttributeEntry> read() {
    for (std::size_t i = 0; i < kVertexAttributeNames.size(); ++i) {
      if (primitive_["attributes"].contains(kVertexAttributeNames[i]))
        add(kVertexAttributeNames[i], static_cast<VertexAttribute>(i));
    }
    auto& members = primitive_["attributes"].get_ref<json::object_t&>();
    for (auto member = members.lower_bound("_"); member != members.end(); ++member) {
      if (member->first[0] != '_') break;
      add_named(member->first);
    }
    std::sort(
        entries_.begin(), entries_.end(),
        [](const AttributeEntry& a, const AttributeEntry& b) { return a.attribute < b.attribute; });
    if (!entries_.empty()) add_targets();
    return std::move(entries_);
  }

 private:
  void warn(JsonChecker& check) {
    document_.warnings.push_back(check.take().message + " and was left out");
  }

  /// The accessor of an attribute; empty if its reference is invalid.
  std::optional<std::uint64_t> accessor_of(json& attributes, const char* name, const Place& list) {
    JsonChecker check;
    const auto accessor = check.reference(attributes, name, list, counts_.accessors, "accessors");
    if (!check.good()) warn(check);
    return accessor;
  }

  void add(const char* name, VertexAttribute attribute) {
    const auto accessor = accessor_of(primitive_["attributes"], name, at_.member("attributes"));
    if (accessor) entries_.push_back({attribute, static_cast<int>(*accessor), draco_id(name)});
  }

  void add_named(const std::string& name) {
    NamedEntries& named = document_.named;
    const auto known = named.by_name.find(name);
    if (known != named.by_name.end()) return add(name.c_str(), known->second);
    if (!is_attribute_name(name) || named.list.size() == NamedEntries::kMost) {
      if (named.left_out++ == 0) named.example = shortened(name);
      return;
    }
    const VertexAttribute attribute = named_attribute(named.list.size());
    add(name.c_str(), attribute);
    if (entries_.empty() || entries_.back().attribute != attribute) return;
    named.list.push_back({name, static_cast<std::size_t>(entries_.back().accessor)});
    named.by_name.emplace(name, attribute);
  }

  std::optional<std::uint32_t> draco_id(const char* name) {
    const auto compressed = draco_ != nullptr ? draco_->find("attributes") : json::iterator();
    if (draco_ == nullptr || compressed == draco_->end() || !compressed->is_object()) return {};
    JsonChecker check;
    const auto id = check.integer(*compressed, name, at_.member("extensions"), 0xffffffffu);
    if (!check.good()) warn(check);
    return id ? std::optional(static_cast<std::uint32_t>(*id)) : std::nullopt;
  }

  void add_targets() {
    const auto targets = primitive_.find("targets");
    if (targets == primitive_.end() || !targets->is_array()) return;
    for (AttributeEntry& entry : entries_) {
      const std::string name(document_.name_of(entry.attribute));
      entry.targets.assign(targets->size(), -1);
      for (std::size_t k = 0; k < targets->size(); ++k) {
        json& target = (*targets)[k];
        if (!target.is_object() || !target.contains(name)) continue;
        const auto accessor = accessor_of(target, name.c_str(), at_.member("targets").element(k));
        entry.targets[k] = accessor ? static_cast<int>(*accessor) : AttributeEntry::kUnusable;
      }
    }
  }

  json& primitive_;
  json* draco_;
  const Counts& counts_;
  GltfDocument& document_;
  const Place& at_;
  std::vector<AttributeEntry> entries_;
};

}  // namespace

void take_attributes(json& primitive, json* draco, const Counts& counts, std::size_t mesh,
                     std::size_t number, GltfDocument& document, const Place& at) {
  auto entries = PrimitiveAttributesReader(primitive, draco, counts, document, at).read();
  if (!entries.empty()) document.attributes.emplace(std::pair(mesh, number), std::move(entries));
}

void warn_of_names(GltfDocument& document) {
  const NamedEntries& named = document.named;
  if (named.left_out == 0) return;
  document.warnings.push_back(
      std::to_string(named.left_out) + " attributes of primitives were left out, such as \"" +
      named.example + "\": hits have the first " + std::to_string(NamedEntries::kMost) +
      " names of 2 to " + std::to_string(kLongestAttributeName) +
      " letters, digits and characters of _.:-");
}

void list_named_attributes(const GltfDocument& document, SceneDescription& scene) {
  for (const NamedEntry& entry : document.named.list) {
    const int type = document.model.accessors[entry.accessor].type;
    const bool is_vector = type >= TINYGLTF_TYPE_VEC2 && type <= TINYGLTF_TYPE_VEC4;
    scene.named_attributes.push_back(
        {entry.name, is_vector ? static_cast<std::uint32_t>(type) : 1, false});
  }
  for (const auto& mesh : scene.meshes) {
    for (const PrimitiveAttributes& attributes : mesh->attributes) {
      for (const auto& entry : attributes.entries) {
        if (entry.attribute >= VertexAttribute::kNamed)
          scene.named_attributes[named_index(entry.attribute)].is_in_scene = true;
      }
    }
  }
}

}  // namespace sightline::gltf
