#include "server/service/hit_terms.h"

#include <algorithm>
#include <unordered_map>
#include <vector>

#include "server/service/node_search.h"

namespace sightline {

namespace {

/// The number of an instance among those of its node, which are neighbours: instances are in the
/// order of nodes.
std::uint32_t number_in_node(const std::vector<Instance>& instances, std::uint32_t instance) {
  const auto first =
      std::lower_bound(instances.begin(), instances.end(), instances[instance].node,
                       [](const Instance& each, std::uint32_t node) { return each.node < node; });
  return instance - static_cast<std::uint32_t>(first - instances.begin());
}

void fill_paths(const SceneDescription& description, const HitBatch& hits, HitTerms& terms) {
  std::unordered_map<std::uint32_t, std::string_view> known;
  terms.node_path.assign(hits.size(), {});
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits.hit(i)) continue;
    const std::uint32_t node = description.instances[hits.instance[i]].node;
    const auto [at, is_new] = known.try_emplace(node);
    if (is_new) at->second = terms.own_texts.emplace_back(node_path(description, node));
    terms.node_path[i] = at->second;
  }
}

}  // namespace

HitTerms hit_terms(const Scene& scene, const HitBatch& hits, FieldSet fields) {
  HitTerms terms;
  const SceneDescription& description = scene.description();
  const bool node_id = fields.has(HitField::kNodeId), node = fields.has(HitField::kNode);
  const bool mesh_id = fields.has(HitField::kMeshId), mesh = fields.has(HitField::kMesh);
  const bool material_id = fields.has(HitField::kMaterialId);
  const bool material = fields.has(HitField::kMaterial);
  const bool primitive = fields.has(HitField::kPrimitive);
  const bool triangle = fields.has(HitField::kTriangle);
  const auto make = [&](auto& column, bool wanted, auto nothing) {
    if (wanted) column.assign(hits.size(), nothing);
  };
  make(terms.node, node_id, kNone);
  make(terms.mesh, mesh_id, kNone);
  make(terms.material, material_id, kNone);
  make(terms.primitive, primitive, kNone);
  make(terms.triangle, triangle, kNone);
  make(terms.node_name, node, std::string_view());
  make(terms.mesh_name, mesh, std::string_view());
  make(terms.material_name, material, std::string_view());

  if (fields.has(HitField::kNodePath)) fill_paths(description, hits, terms);
  if (fields.has(HitField::kNodeInstance)) {
    make(terms.node_instance, true, kNone);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (hits.hit(i))
        terms.node_instance[i] = number_in_node(description.instances, hits.instance[i]);
    }
  }
  const bool others =
      fields.has_any_of({HitField::kNodeId, HitField::kNode, HitField::kMeshId, HitField::kMesh,
                         HitField::kMaterialId, HitField::kMaterial});
  if (!others && !primitive && !triangle) return terms;
  // Neighbours often meet the same one.
  std::uint32_t instance = kNone, first = 0, count = 0, part_number = 0;
  const Node* its_node = nullptr;
  const Mesh* its_mesh = nullptr;
  std::uint32_t its_material = kNone;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits.hit(i)) continue;
    const TriangleId id = hits.id(i);
    if (id.instance != instance || id.triangle - first >= count) {
      instance = id.instance;
      const Instance& placed = description.instances[instance];
      its_node = &description.nodes[placed.node];
      its_mesh = description.meshes[placed.mesh].get();
      const Primitive& part = its_mesh->primitives[scene.primitive_of(id)];
      first = part.first_triangle;
      count = part.triangle_count;
      part_number = part.file_primitive;
      its_material = part.material;
    }
    if (primitive) terms.primitive[i] = part_number;
    if (triangle) terms.triangle[i] = id.triangle - first;
    if (!others) continue;
    if (node_id) terms.node[i] = its_node->file_node;
    if (node) terms.node_name[i] = its_node->name;
    if (mesh_id) terms.mesh[i] = its_mesh->file_mesh;
    if (mesh) terms.mesh_name[i] = its_mesh->name;
    if (material_id) terms.material[i] = its_material;
    if (material && its_material < description.materials.size()) {
      terms.material_name[i] = description.materials[its_material].name;
    }
  }
  return terms;
}

Status read_attributes(const Engine& engine, const DescribedHits& described,
                       const Deadline& deadline, HitDescription& description) {
  const FieldSet fields = described.fields;
  if (!fields.has_any_of(kAttributeFields)) return success();
  return engine.attributes(described.scene, described.hits, description.details,
                           {fields.has(HitField::kShadingNormal), fields.has(HitField::kUv),
                            fields.has(HitField::kColour), fields.has(HitField::kUv1),
                            fields.has(HitField::kTangent), described.named},
                           deadline, description.terms.attributes);
}

Status describe_hits(const Engine& engine, const DescribedHits& described, const Deadline& deadline,
                     HitDescription& description) {
  const auto& [scene, rays, hits, fields, normalize, resolved, named] = described;
  Status status = success();
  if (fields.has_any_of(kDetailFields)) {
    status = engine.details(scene, rays, hits, deadline, description.details);
  }
  if (status && fields.has(HitField::kOnEdge)) {
    status = engine.mark_edges(scene, rays, hits, deadline, description.details);
  }
  if (!status) return status;
  HitTerms& terms = description.terms;
  terms = hit_terms(scene, hits, fields);
  status = read_attributes(engine, described, deadline, description);
  if (status && fields.has_any_of(kCostFields))
    status = engine.costs(scene, rays, deadline, terms.costs, {.resolved = resolved});
  if (!status) return status;
  terms.t_is_distance = normalize;
  if (normalize || fields.has(HitField::kDistance)) {
    terms.distance.resize(hits.size());
    for (std::size_t i = 0; i < hits.size(); ++i)
      terms.distance[i] = distance_of(hits.t[i], rays[i].direction);
  }
  return success();
}

RayBatch rays_of_hits(const RayBatch& rays, const HitLists& lists) {
  RayBatch repeated;
  repeated.reserve(lists.hits.size());
  for (std::size_t ray = 0; ray < rays.size(); ++ray) {
    for (std::size_t i = lists.first[ray]; i < lists.first[ray + 1]; ++i) {
      repeated.push_back(rays[ray]);
      if (!rays.mask.empty()) repeated.mask.push_back(rays.mask[ray]);
    }
  }
  return repeated;
}

}  // namespace sightline
