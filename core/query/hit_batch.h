#pragma once
/// Hits as columns: slot i answers ray i.

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/column.h"
#include "core/geometry/vec3.h"

namespace sightline {

inline constexpr std::uint32_t kNone = 0xffffffffu;

/// Names one triangle of a scene. Ids are ordered by (instance, triangle): file order, because a
/// mesh counts its triangles through its primitives. The smaller id wins when t is equal.
struct TriangleId {
  std::uint32_t instance = kNone;
  std::uint32_t triangle = kNone;  ///< index in the mesh, through all its primitives
  auto operator<=>(const TriangleId&) const = default;
};

/// Closest hits: n slots. A miss has t = +inf and both ids kNone.
struct HitBatch {
  Column<double> t;  ///< the exact t rounded once to the nearest float64
  Column<std::uint32_t> instance;
  Column<std::uint32_t> triangle;

  std::size_t size() const { return t.size(); }
  void resize(std::size_t count) {
    t.resize(count);
    instance.resize(count);
    triangle.resize(count);
  }
  void append(const HitBatch& other) {
    t.insert(t.end(), other.t.begin(), other.t.end());
    instance.insert(instance.end(), other.instance.begin(), other.instance.end());
    triangle.insert(triangle.end(), other.triangle.begin(), other.triangle.end());
  }
  TriangleId id(std::size_t i) const { return {instance[i], triangle[i]}; }
  bool hit(std::size_t i) const { return instance[i] != kNone; }
};

/// Lists of hits ("all"): those of ray i are entries first[i] .. first[i+1] of `hits`.
struct HitLists {
  Column<std::size_t> first;  ///< n + 1 entries
  HitBatch hits;
};

/// Which of the triangles that a ray meets count for "all" and "count".
enum class Crossings {
  kEvery,  ///< every triangle met: a shared edge gives two hits, a corner as many as meet there
  /// Those that the ray crosses after an infinitely small movement of its origin (exact_hit.h): a
  /// passage through a closed surface counts once, wherever it happens, a touch never or twice.
  kOnce,
};

/// Which hits of each ray are listed.
struct HitListQuestion {
  Crossings crossings = Crossings::kEvery;
  std::size_t each_max = 0;   ///< the first hits of each ray that are listed
  std::size_t total_max = 0;  ///< of all rays in total: more are an error
};

/// Computed for the winner only, and only when asked.
struct HitDetail {
  Vec3d position;        ///< within one ulp per coordinate of the exact point
  Vec3d normal;          ///< geometric, unit, (v1-v0)x(v2-v0) of the world triangle; within 1e-15
  double u = 0;          ///< weight of v1, within 2^-50
  double v = 0;          ///< weight of v2, within 2^-50
  bool front = true;     ///< direction . normal < 0 exactly; false when the ray lies in the plane
  bool on_edge = false;  ///< exactly on an edge or a corner; only if asked for (Engine::mark_edges)
};

/// What the file says of the surface at a hit: of the three vertices a, b, c with the weights of
/// HitDetail ((1 - u) - v) a + u b + v c, in float64, left to right. Columns of n slots, or none
/// when not asked for; NaN where the file says nothing, or not a number.
struct HitAttributes {
  Column<Vec3d> shading_normal;          ///< unit, world, by the inverse transpose (normal_map.h)
  Column<std::array<double, 2>> uv;      ///< TEXCOORD_0
  Column<std::array<double, 4>> colour;  ///< COLOR_0: red, green, blue, alpha (1 if there is none)
};
struct HitAttributeChoice {
  bool shading_normal = false, uv = false, colour = false;
};

}  // namespace sightline

// Tests: tests/unit/proto/hit_json_test.cpp
