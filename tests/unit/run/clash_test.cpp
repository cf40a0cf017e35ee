// Kinds and depths of pairs of convex bodies on a grid, against the faces of their Minkowski
// difference, which are found in integers among all triples of its points.

#include "core/run/clash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/run/resolved_filter.h"
#include "tests/oracle/hull_distance.h"
#include "tests/oracle/nearest_point.h"
#include "tests/oracle/random.h"
#include "tests/oracle/whole_hulls.h"
#include "tests/support/random_cases.h"

namespace sightline::clashes {
namespace {

using oracle::cross;
using oracle::dot;
using oracle::minus;
using oracle::Whole;

/// A convex body: its corners and its triangles.
struct Solid {
  std::vector<Whole> corners;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

struct Plane {
  Whole normal;
  long long offset;
};

/// The planes of all faces of the hull: through three points, with none beyond.
std::vector<Plane> faces_of(const std::vector<Whole>& points) {
  std::vector<Plane> faces;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      for (std::size_t k = j + 1; k < points.size(); ++k) {
        Whole n = cross(minus(points[j], points[i]), minus(points[k], points[i]));
        if (n == Whole{}) continue;
        long long least = 0, most = 0;
        for (const Whole& p : points) {
          const long long height = dot(n, minus(p, points[i]));
          least = std::min(least, height);
          most = std::max(most, height);
        }
        if (least < 0 && most > 0) continue;
        if (most > 0) n = {-n[0], -n[1], -n[2]};
        faces.push_back({n, dot(n, points[i])});
      }
    }
  }
  return faces;
}

struct Truth {
  ClashKind kind = ClashKind::kApart;
  mpq_class square_depth = 0;  ///< 0: the interiors do not overlap
  bool meet = false;
};

std::set<std::set<Whole>> triangles_of(const Solid& solid) {
  std::set<std::set<Whole>> all;
  for (const auto& t : solid.triangles)
    all.insert({solid.corners[t[0]], solid.corners[t[1]], solid.corners[t[2]]});
  return all;
}

/// Whether all corners are inside or on the surface, and one is inside.
bool is_in(const Solid& inner, const Solid& outer) {
  const auto faces = faces_of(outer.corners);
  bool has_inner = false;
  for (const Whole& p : inner.corners) {
    bool is_inner = true;
    for (const Plane& face : faces) {
      const long long height = dot(face.normal, p) - face.offset;
      if (height > 0) return false;
      is_inner = is_inner && height < 0;
    }
    has_inner = has_inner || is_inner;
  }
  return has_inner;
}

Truth truth_of(const Solid& a, const Solid& b, double max_distance) {
  std::set<Whole> points;
  for (const Whole& p : a.corners) {
    for (const Whole& q : b.corners) points.insert(minus(p, q));
  }
  Truth truth;
  bool is_first = true;
  long long least = 1;
  for (const Plane& face : faces_of({points.begin(), points.end()})) {
    least = std::min(least, face.offset);
    mpq_class square(static_cast<long>(face.offset * face.offset),
                     static_cast<long>(dot(face.normal, face.normal)));
    square.canonicalize();
    if (is_first || square < truth.square_depth) truth.square_depth = square;
    is_first = false;
  }
  truth.meet = least >= 0;
  if (least <= 0) truth.square_depth = 0;
  if (triangles_of(a) == triangles_of(b)) {
    truth.kind = ClashKind::kDuplicate;
  } else if (is_in(a, b)) {
    truth.kind = ClashKind::kAInB;
  } else if (is_in(b, a)) {
    truth.kind = ClashKind::kBInA;
  } else if (least > 0) {
    truth.kind = ClashKind::kCrossing;
  } else if (truth.meet) {
    truth.kind = ClashKind::kTouching;
  } else {
    const auto exact = [](const Solid& solid) {
      std::vector<oracle::ExactPoint> all;
      for (const Whole& p : solid.corners) {
        all.push_back(oracle::exact_point(
            {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}));
      }
      return all;
    };
    if (a.corners.size() + b.corners.size() < 10 &&
        oracle::hull_square_distance(exact(a), exact(b)) <=
            mpq_class(max_distance) * mpq_class(max_distance)) {
      truth.kind = ClashKind::kNear;
    }
  }
  return truth;
}

Solid tetrahedron(oracle::Random& random, int size) {
  for (;;) {
    Solid solid;
    for (int i = 0; i < 4; ++i) {
      solid.corners.push_back(
          {random.integer(0, size), random.integer(0, size), random.integer(0, size)});
    }
    const auto& c = solid.corners;
    if (dot(minus(c[1], c[0]), cross(minus(c[2], c[0]), minus(c[3], c[0]))) == 0) continue;
    solid.triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
    return solid;
  }
}

Solid box(oracle::Random& random, int size) {
  Whole low{}, high{};
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = random.integer(0, size - 1);
    high[k] = random.integer(static_cast<int>(low[k]) + 1, size);
  }
  Solid solid;
  for (int corner = 0; corner < 8; ++corner) {
    Whole p{};
    for (std::size_t k = 0; k < 3; ++k) p[k] = (corner >> k & 1) != 0 ? high[k] : low[k];
    solid.corners.push_back(p);
  }
  constexpr std::uint32_t kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                          {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& f : kFaces) {
    solid.triangles.push_back({f[0], f[1], f[2]});
    solid.triangles.push_back({f[0], f[2], f[3]});
  }
  return solid;
}

/// A box around all bodies with coordinates from 0 to `size`.
Solid box_around(oracle::Random& random, int size) {
  Solid solid = box(random, 1);
  for (Whole& p : solid.corners) {
    for (long long& x : p) x = x == 0 ? -1 : size + 1;
  }
  return solid;
}

std::shared_ptr<const Scene> scene_of(const Solid& a, const Solid& b) {
  SceneDescription description;
  for (const Solid* solid : {&a, &b}) {
    auto mesh = std::make_shared<Mesh>();
    for (const Whole& p : solid->corners) {
      mesh->positions.own().push_back(
          {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    }
    for (const auto& t : solid->triangles) {
      for (const std::uint32_t corner : t) mesh->indices.own().push_back(corner);
    }
    mesh->primitives.push_back({0, mesh->triangle_count(), 0, kNone});
    Instance instance;
    instance.mesh = instance.node = static_cast<std::uint32_t>(description.nodes.size());
    description.meshes.push_back(std::move(mesh));
    description.nodes.push_back({});
    description.instances.push_back(instance);
  }
  return *Scene::build(std::move(description));
}

std::string described(const Solid& solid) {
  std::string text = ";";
  for (const Whole& p : solid.corners) {
    for (const long long x : p) text += " " + std::to_string(x);
    text += ",";
  }
  return text;
}

ClearanceAnswer ask(const Engine& engine, const Scene& scene, double max_distance) {
  const ResolvedFilter a{{0, 1}, {ResolvedFilter::kAll, 0}}, b{{0, 1}, {0, ResolvedFilter::kAll}};
  ClearanceQuestion question;
  question.pairs = ClearancePairs::kNodes;
  question.max_distance = max_distance;
  question.kinds = true;
  ClearanceAnswer answer;
  const Status status = engine.clearance(scene, a, b, question, Deadline::never(), answer);
  EXPECT_TRUE(status);
  return answer;
}

TEST(NodeClashes, are_those_of_the_minkowski_difference) {
  constexpr std::uint64_t kSeed = 2402;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  oracle::Random random(kSeed);
  const auto engine = *Engine::create({1, ""});
  std::array<std::size_t, kClashKindCount> seen{};
  std::size_t depths = 0;
  const int cases = test::random_cases(4000);
  for (int round = 0; round < cases; ++round) {
    const int size = random.integer(2, 6);
    const bool has_box = random.chance(0.15);
    Solid a = has_box ? box(random, size) : tetrahedron(random, size);
    Solid b = has_box && random.chance(0.6) ? box(random, size) : tetrahedron(random, size);
    // Small ones inside of large ones, equal ones, and others beside each other.
    if (random.chance(0.2)) {
      for (Whole& p : b.corners) {
        for (long long& x : p) x = 3 * x - size;
      }
    }
    if (random.chance(0.04)) b = box_around(random, size);
    if (random.chance(0.04)) a = box_around(random, 3 * size);
    if (random.chance(0.05)) {
      b = a;
      std::rotate(b.triangles.begin(), b.triangles.begin() + 1, b.triangles.end());
    }
    if (random.chance(0.3)) {
      const int by = random.integer(1, size + 2);
      for (Whole& p : b.corners) p[0] += by;
    }
    const double max_distance = random.integer(0, 2);
    const Truth truth = truth_of(a, b, max_distance);
    const ClearanceAnswer answer = ask(*engine, *scene_of(a, b), max_distance);
    ClashKind found = answer.pairs.empty() ? ClashKind::kApart : answer.pairs[0].kind;
    // The judge knows the distance of small bodies only.
    if (found == ClashKind::kNear && a.corners.size() + b.corners.size() >= 10)
      found = ClashKind::kApart;
    ASSERT_EQ(static_cast<int>(found), static_cast<int>(truth.kind))
        << "round " << round << described(a) << described(b) << " within " << max_distance;
    ++seen[static_cast<std::size_t>(found)];
    std::uint64_t counted = 0;
    for (const std::uint64_t kind : answer.kinds) counted += kind;
    ASSERT_EQ(counted, 1u);
    if (answer.pairs.empty() || std::isnan(answer.pairs[0].depth)) {
      ASSERT_FALSE(truth.meet) << "round " << round;
      continue;
    }
    ASSERT_TRUE(oracle::is_rounded_root(answer.pairs[0].depth, truth.square_depth))
        << "round " << round << ": " << answer.pairs[0].depth;
    ++depths;
  }
  std::printf(
      "duplicate %zu, a in b %zu, b in a %zu, crossing %zu, touching %zu, near %zu, apart "
      "%zu; %zu depths; wrong 0\n",
      seen[0], seen[1], seen[2], seen[3], seen[4], seen[5], seen[6], depths);
  for (const std::size_t count : seen) EXPECT_GT(count, test::random_cases(40u));
}

TEST(NodeClashes, have_no_depth_unless_both_are_convex) {
  oracle::Random random(2403);
  const auto engine = *Engine::create({1, ""});
  Solid a = box(random, 4), open = a;
  open.triangles.pop_back();
  const ClearanceAnswer answer = ask(*engine, *scene_of(a, open), 0);
  ASSERT_EQ(answer.pairs.size(), 1u);
  EXPECT_TRUE(std::isnan(answer.pairs[0].depth));
  EXPECT_EQ(static_cast<int>(answer.pairs[0].kind), static_cast<int>(ClashKind::kTouching));
}

}  // namespace
}  // namespace sightline::clashes
