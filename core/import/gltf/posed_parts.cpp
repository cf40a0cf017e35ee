#include "core/import/gltf/posed_parts.h"

#include <functional>
#include <utility>

namespace sightline::gltf {

namespace {

std::pair<std::uint64_t, std::uint64_t> part_of(std::span<const std::byte> whole,
                                                std::span<const std::byte> part) {
  return {static_cast<std::uint64_t>(part.data() - whole.data()), part.size()};
}

bool is_inside(std::span<const std::byte> whole, std::span<const std::byte> part) {
  return !std::less<>()(part.data(), whole.data()) &&
         !std::less<>()(whole.data() + whole.size(), part.data() + part.size());
}

}  // namespace

void PosedParts::add_node(const tinygltf::Node& node) {
  const GltfDocument& document = file_.document;
  if (node.mesh < 0) return;
  const auto mesh = static_cast<std::size_t>(node.mesh);
  if (node.skin < 0 && morph_targets_[mesh] == 0) return;
  has_any_ = true;
  if (node.skin >= 0) {
    if (const auto binds = document.skins[static_cast<std::size_t>(node.skin)].inverse_binds)
      add_accessor(static_cast<int>(*binds));
  }
  if (!meshes_.insert(mesh).second) return;
  const auto& primitives = document.model.meshes[mesh].primitives;
  for (std::size_t i = 0; i < primitives.size(); ++i) add_primitive(mesh, i, primitives[i]);
}

void PosedParts::add_animation(const AnimationEntry& animation) {
  has_any_ = true;
  for (const AnimationSamplerEntry& sampler : animation.samplers) {
    add_accessor(static_cast<int>(sampler.input));
    add_accessor(static_cast<int>(sampler.output));
  }
}

Result<Retained> PosedParts::retain(Budget& budget) {
  const std::span<const std::byte> whole = file_.shared.bytes;
  FileParts own{part_of(whole, file_.chunks.json)};
  std::map<std::size_t, FileParts> others;
  for (const std::size_t view : views_) add_view(view, own, others);
  own = merged(std::move(own));
  Retained retained;
  const bool is_held = file_.shared.owner != nullptr;
  std::uint64_t copied = is_held ? 0 : bytes_of(own);
  for (auto& [buffer, parts] : others) {
    parts = merged(std::move(parts));
    copied += bytes_of(parts);
  }
  if (Status status = budget.spend_bytes(copied); !status) return std::move(status).error();
  retained.copied = copied;
  if (is_held) {
    retained.file = {whole, file_.shared.owner, {}};
    for (const auto& [begin, length] : own) {
      if (file_.shared.claim) file_.shared.claim(whole.subspan(begin, length));
    }
  } else {
    const auto copy = std::make_shared<const RetainedBytes>(whole, own);
    retained.file = {copy->bytes(), copy, {}};
  }
  const auto moved = [&](std::span<const std::byte> part) {
    const auto [begin, length] = part_of(whole, part);
    return retained.file.bytes.subspan(begin, length);
  };
  retained.json = moved(file_.chunks.json);
  if (file_.chunks.binary) retained.binary = moved(*file_.chunks.binary);
  for (const auto& [buffer, parts] : others) {
    auto bytes = file_.buffers.bytes(buffer);
    if (!bytes) return std::move(bytes).error();
    retained.buffers[buffer] = std::make_shared<const RetainedBytes>(*bytes, parts);
  }
  for (std::size_t i = 0; i < file_.document.buffers.size(); ++i) {
    if (!file_.buffers.is_mapped(i) && file_.buffers.is_at_hand(i)) retained.data_uris.push_back(i);
  }
  return retained;
}

void PosedParts::add_primitive(std::size_t mesh, std::size_t number,
                               const tinygltf::Primitive& primitive) {
  const GltfDocument& document = file_.document;
  for (const auto& [name, accessor] : primitive.attributes) add_accessor(accessor);
  add_accessor(primitive.indices);
  for (const auto& target : primitive.targets) {
    for (const auto& [name, accessor] : target) add_accessor(accessor);
  }
  if (const auto draco = document.draco.find({mesh, number}); draco != document.draco.end())
    views_.insert(draco->second.view);
  const auto entry = document.attributes.find({mesh, number});
  if (entry == document.attributes.end()) return;
  for (const AttributeEntry& attribute : entry->second) {
    add_accessor(attribute.accessor);
    for (const int accessor : attribute.targets) add_accessor(accessor);
  }
}

void PosedParts::add_accessor(int index) {
  if (index < 0) return;
  const tinygltf::Accessor& accessor =
      file_.document.model.accessors[static_cast<std::size_t>(index)];
  if (GltfDocument::has_view(accessor)) add(accessor.bufferView);
  if (!accessor.sparse.isSparse) return;
  add(accessor.sparse.indices.bufferView);
  add(accessor.sparse.values.bufferView);
}

/// Adds the bytes of a view to the parts of their file. Leaves out what is invalid: a pose that
/// needs it is an error.
void PosedParts::add_view(std::size_t number, FileParts& own,
                          std::map<std::size_t, FileParts>& others) {
  ViewStore& views = file_.accessors.views();
  if (!views.is_at_hand(number)) return;
  const bool is_meshopt = views.is_meshopt(number);
  const auto bytes = is_meshopt ? views.to_decode(number) : views.bytes(number);
  if (!bytes) return;
  if (is_inside(file_.shared.bytes, *bytes))
    return own.push_back(part_of(file_.shared.bytes, *bytes));
  const std::size_t buffer =
      is_meshopt ? file_.document.meshopt.at(number).buffer
                 : static_cast<std::size_t>(file_.document.model.bufferViews[number].buffer);
  // A data URI is a part of the JSON.
  if (!file_.buffers.is_mapped(buffer)) return;
  const auto whole = file_.buffers.bytes(buffer);
  if (whole) others[buffer].push_back(part_of(*whole, *bytes));
}

}  // namespace sightline::gltf
