#pragma once
/// Parts of a scene as JSON: triangles, animations and the self-check.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/run/self_check.h"
#include "core/scene/poser.h"
#include "core/scene/scene.h"

namespace sightline {

/// Returns {"triangles":[{"instance","primitive","triangle","corners":[[x,y,z],...],"node_id",
/// "material_id"}]} with the exact float64 corners in world space. `ids` are
/// "instance.primitive.triangle" as in hits, separated by commas. Errors: TRIANGLE_UNKNOWN, naming
/// the invalid id; TOO_MANY_TRIANGLES.
Result<std::string> encode_triangles(const Scene& scene, std::string_view ids);
/// The most ids of encode_triangles.
inline constexpr std::size_t kMostTriangles = 1000;

/// Returns {"total":1,"animations":[{"index":0,"name":"walk","duration":1.25,"nodes":[3,4]}]} in the
/// order of the file. One that cannot be sampled has the duration null and a "problem".
std::string encode_animations(const std::vector<AnimationSummary>& animations);

/// Returns {"rays","hits","triangles_decided","different":[...]}.
std::string encode_self_check(const SelfCheck& check);

}  // namespace sightline

// Tests: tests/integration/parts_test.py
