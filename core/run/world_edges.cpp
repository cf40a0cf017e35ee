#include "core/run/world_edges.h"

#include <map>
#include <utility>

#include "core/run/resolved_filter.h"

namespace sightline {

Result<std::vector<OpenEdge>> open_edges_in_world(const Scene& scene,
                                                  const ResolvedFilter* resolved,
                                                  const Deadline& deadline,
                                                  const ReserveBytes& reserve) {
  const SceneDescription& description = scene.description();
  // The open edges of each mesh for each set of primitives that count: most placements of a mesh
  // have one set.
  std::map<std::pair<std::uint32_t, std::vector<bool>>, std::vector<UnbalancedEdge>> known;
  std::vector<OpenEdge> edges;
  DeadlineWatch watch(deadline);
  for (std::size_t i = 0; i < description.instances.size(); ++i) {
    const Instance& instance = description.instances[i];
    const Mesh& mesh = *description.meshes[instance.mesh];
    if (watch.passed(1 + mesh.primitives.size())) return watch.error();
    if (instance.hidden) continue;
    const std::vector<bool> counts = counting_primitives(scene, i, resolved);
    const auto [place, is_new] =
        known.try_emplace({instance.mesh, counts}, std::vector<UnbalancedEdge>());
    std::vector<UnbalancedEdge>& open = place->second;
    if (is_new) {
      const auto is_chosen = [&](std::size_t primitive) { return counts[primitive]; };
      if (Status status = ask_for(reserve, open_edges_bytes(mesh, is_chosen)); !status)
        return std::move(status).error();
      auto found = open_edges(mesh, is_chosen, deadline, &open);
      if (!found) return std::move(found).error();
      if (Status status = ask_for(reserve, open.size() * sizeof(UnbalancedEdge)); !status)
        return std::move(status).error();
    }
    if (Status status = ask_for(reserve, open.size() * sizeof(OpenEdge)); !status)
      return std::move(status).error();
    if (watch.passed(1 + open.size())) return watch.error();
    for (const UnbalancedEdge& edge : open) {
      edges.push_back({instance.world_from_mesh.apply(mesh.positions[edge.from]),
                       instance.world_from_mesh.apply(mesh.positions[edge.to]),
                       static_cast<double>(edge.times)});
    }
  }
  return edges;
}

}  // namespace sightline
