#pragma once
/// What scale_bench has measured, and what it says of growth.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace sightline::bench {

/// One kind of rays over a scene of one size.
struct ScaleRow {
  std::string subject, rays;  ///< "triangles" or "instances"; the rays' name
  std::uint64_t size = 0;     ///< how many of the subject
  double ns_per_ray = 0, least = 0, most = 0;
  double warm_ns_per_ray = 0;  ///< of rays whose nodes and blocks are in the caches already
  /// The same, where the processor has just taken the same branches too.
  double learned_ns_per_ray = 0;
  double nodes_per_ray = 0, blocks_per_ray = 0;
  double build_seconds = 0;
  double tree_bytes = 0;
  double peak_mib = 0;                   ///< of the whole process, making the scene included
  double embree1_ns = 0, embree_ns = 0;  ///< its single rays, its best entry; 0: not measured
  std::string embree;                    ///< the name of the latter
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ScaleRow, subject, rays, size, ns_per_ray, least, most,
                                   warm_ns_per_ray, learned_ns_per_ray, nodes_per_ray,
                                   blocks_per_ray, build_seconds, tree_bytes, peak_mib, embree1_ns,
                                   embree_ns, embree)

/// Lines "floor N: ...", and lines "growth: ..." that say how the growth comes about.
std::vector<std::string> scale_floors(const std::vector<ScaleRow>& rows);
std::vector<std::string> scale_growth(const std::vector<ScaleRow>& rows);

/// scale.json, scale.csv, scale.md. False if they cannot be written.
bool write_scale_report(const std::vector<ScaleRow>& rows, const std::string& folder);

}  // namespace sightline::bench
