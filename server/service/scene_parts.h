#pragma once
/// The parts of a scene as JSON: nodes, triangles and a self-check.

#include <optional>
#include <string>
#include <string_view>

#include "core/run/self_check.h"
#include "core/scene/scene.h"

namespace sightline {

/// {"total":5,"nodes":[{"node_id","name","parent","instances","triangles","bounds":{"min","max"}}],
/// "next":2}: `limit` nodes from number `first` on, in the order of a depth-first walk; "next" is
/// left out at the end. Of each its own placements, world bounds null without any; "parent" is a
/// node_id or null.
std::string encode_nodes(const Scene& scene, std::uint64_t first, std::uint64_t limit);

/// {"triangles":[{"instance","primitive","triangle","corners":[[x,y,z],...],"node_id","material_id"}]},
/// the exact float64 corners in the world. `ids` is "instance.primitive.triangle" as hits name
/// them, with commas between them. Errors: TRIANGLE_UNKNOWN, naming what is none;
/// TOO_MANY_TRIANGLES.
Result<std::string> encode_triangles(const Scene& scene, std::string_view ids);
inline constexpr std::size_t kMostTriangles = 1000;

/// {"rays","hits","triangles_decided","different":[...]}
std::string encode_self_check(const SelfCheck& check);

}  // namespace sightline
