#pragma once
/// Hits as columns: slot i, the element i of every column, answers query i (a ray, sweep or point).

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/column.h"
#include "core/geometry/vec3.h"

namespace sightline {

/// The value of `instance` and `triangle` of a miss.
inline constexpr std::uint32_t kNone = 0xffffffffu;

/// The id of a triangle of a scene. Ids are ordered by (instance, triangle), which is the order of
/// the file. Of triangles with equal t, the triangle with the smaller id is the closest hit.
struct TriangleId {
  std::uint32_t instance = kNone;  ///< index in SceneDescription::instances
  std::uint32_t triangle = kNone;  ///< index in the mesh, counted through all its primitives
  auto operator<=>(const TriangleId&) const = default;
};

/// A triangle as clients name it: by the fields "instance", "primitive" and "triangle" of its hits.
struct TriangleName {
  std::uint32_t instance = kNone;   ///< index in SceneDescription::instances
  std::uint32_t primitive = kNone;  ///< index in the file's mesh
  std::uint32_t triangle = kNone;   ///< index in the primitive
};

/// n hits, a slot for each. A miss has t = +inf and both ids kNone.
struct HitBatch {
  /// The exact t rounded once to the nearest float64, in units of |direction|; for a point its
  /// distance in scene units.
  Column<double> t;
  Column<std::uint32_t> instance;
  Column<std::uint32_t> triangle;

  std::size_t size() const { return t.size(); }
  /// Sets the number of slots; new slots are zero, not misses.
  void resize(std::size_t count) {
    t.resize(count);
    instance.resize(count);
    triangle.resize(count);
  }
  /// Appends the slots of `other`, which must not be this batch.
  void append(const HitBatch& other) {
    t.insert(t.end(), other.t.begin(), other.t.end());
    instance.insert(instance.end(), other.instance.begin(), other.instance.end());
    triangle.insert(triangle.end(), other.triangle.begin(), other.triangle.end());
  }
  /// Copies slot `from` of `other` to slot `to` of this batch. Precondition: both exist.
  void copy(const HitBatch& other, std::size_t from, std::size_t to) {
    t[to] = other.t[from];
    instance[to] = other.instance[from];
    triangle[to] = other.triangle[from];
  }
  /// The triangle of slot i. Precondition: i < size().
  TriangleId id(std::size_t i) const { return {instance[i], triangle[i]}; }
  /// True if slot i has a hit.
  bool hit(std::size_t i) const { return instance[i] != kNone; }
};

/// The lists of hits of n rays (question "all"): the hits of ray i are the slots first[i] ..
/// first[i+1] - 1 of `hits`, sorted by (exact t, id).
struct HitLists {
  Column<std::size_t> first;  ///< n + 1 elements
  HitBatch hits;
};

/// Which triangles count as crossed by a ray, for "all" and "count".
enum class Crossings {
  /// every triangle that the ray meets: a shared edge gives two hits, a shared corner more
  kEvery,
  /// Triangles that the ray crosses after an infinitely small displacement of its origin
  /// (exact_hit.h). So a passage through a closed surface counts once, also at an edge or corner;
  /// where the ray only touches the surface, it counts never or twice.
  kOnce,
};

/// The options of the question "all", which lists hits.
struct HitListQuestion {
  Crossings crossings = Crossings::kEvery;
  std::size_t each_max = 0;  ///< most hits in the list of a ray: its first ones
  /// The query fails if the lists of all rays have more hits than this in total.
  std::size_t total_max = 0;
};

/// Properties of a hit. They are computed only for hits that are reported, and only on request. The
/// default values belong to a miss.
struct HitDetail {
  Vec3d position;  ///< within one ulp per coordinate of the exact point
  Vec3d normal;    ///< unit normal of the world triangle, (v1-v0)x(v2-v0) normalised; within 1e-15
  double u = 0;    ///< barycentric weight of v1, within 2^-50
  double v = 0;    ///< barycentric weight of v2, within 2^-50
  /// direction . normal < 0, exactly; false if the ray lies in the triangle's plane
  bool front = true;
  bool on_edge = false;  ///< exactly on an edge or a corner; set only by Engine::mark_edges
};

/// A vertex attribute that the file names (attribute_name.h), interpolated at n hits.
struct NamedColumn {
  std::string name;
  std::size_t width = 1;   ///< numbers for each hit, 1 to 4
  Column<double> numbers;  ///< n * width
};

/// Vertex attributes of the file, interpolated at hits: ((1 - u) - v) a + u b + v c for the values
/// a, b, c of the three vertices, in float64, left to right. Each requested column has a slot for
/// each hit. A slot is NaN for a miss, or if the file has no value or a value that is not finite.
struct HitAttributes {
  /// unit vector, in world space, by the inverse transpose (normal_map.h)
  Column<Vec3d> shading_normal;
  Column<std::array<double, 2>> uv;   ///< TEXCOORD_0
  Column<std::array<double, 2>> uv1;  ///< TEXCOORD_1
  /// Unit, in world space, by the matrix of the instance. The fourth number is 1 or -1: that times
  /// the cross product of shading normal and tangent is the direction of the bitangent.
  Column<std::array<double, 4>> tangent;
  /// COLOR_0: linear red, green, blue and alpha (1 if the file has none)
  Column<std::array<double, 4>> colour;
  /// Those that the file names and the request asks for, in its order.
  std::vector<NamedColumn> named;
};
/// Which columns of HitAttributes are requested.
struct HitAttributeChoice {
  bool shading_normal = false, uv = false, colour = false, uv1 = false, tangent = false;
  std::span<const std::string> named = {};
};

}  // namespace sightline

// Tests: tests/unit/proto/hit_json_test.cpp
