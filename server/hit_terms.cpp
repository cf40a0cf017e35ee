#include "server/hit_terms.h"

namespace sightline {

HitTerms hit_terms(const Scene& scene, const HitBatch& hits, FieldSet fields) {
  HitTerms terms;
  const SceneDescription& description = scene.description();
  const bool node_id = fields.has(HitField::kNodeId), node = fields.has(HitField::kNode);
  const bool mesh_id = fields.has(HitField::kMeshId), mesh = fields.has(HitField::kMesh);
  const bool material_id = fields.has(HitField::kMaterialId);
  const bool material = fields.has(HitField::kMaterial);
  const bool primitive = fields.has(HitField::kPrimitive);
  const bool triangle = fields.has(HitField::kTriangle);
  const bool in_primitive = material_id || material || primitive || triangle;
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

  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits.hit(i)) continue;
    const TriangleId id = hits.id(i);
    const Instance& instance = description.instances[id.instance];
    const Node& its_node = description.nodes[instance.node];
    const Mesh& its_mesh = *description.meshes[instance.mesh];
    if (node_id) terms.node[i] = its_node.file_node;
    if (node) terms.node_name[i] = its_node.name;
    if (mesh_id) terms.mesh[i] = its_mesh.file_mesh;
    if (mesh) terms.mesh_name[i] = its_mesh.name;
    if (!in_primitive) continue;
    const Primitive& part = its_mesh.primitives[scene.primitive_of(id)];
    if (primitive) terms.primitive[i] = part.file_primitive;
    if (triangle) terms.triangle[i] = id.triangle - part.first_triangle;
    if (material_id) terms.material[i] = part.material;
    if (material && part.material < description.materials.size()) {
      terms.material_name[i] = description.materials[part.material].name;
    }
  }
  return terms;
}

RayBatch rays_of_hits(const RayBatch& rays, const HitLists& lists) {
  RayBatch repeated;
  repeated.reserve(lists.hits.size());
  for (std::size_t ray = 0; ray < rays.size(); ++ray) {
    for (std::size_t i = lists.first[ray]; i < lists.first[ray + 1]; ++i) {
      repeated.push_back(rays[ray]);
    }
  }
  return repeated;
}

}  // namespace sightline
