// Boxes against scenes: the walk must find exactly the triangles that the exact predicate finds one
// by one, and those are the oracle's.

#include "core/trace/search/box_overlap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/infinity.h"
#include "core/geometry/exact_hit.h"
#include "core/geometry/triangle_box.h"
#include "core/geometry/triangle_within.h"
#include "core/trace/search/box_region.h"
#include "tests/oracle/box_oracle.h"
#include "tests/oracle/random.h"
#include "tests/oracle/world_triangles.h"
#include "tests/unit/trace/awkward_scenes.h"

namespace sightline {
namespace {

using oracle::Random;
using test::Case;
using test::cases;
using test::kTriangles;
using test::make_scene;
BoxBatch make_boxes(const Case& c, const Scene& scene, Random& random, int count) {
  BoxBatch boxes;
  const auto instances = scene.description().instances.size();
  const double s = static_cast<double>(c.scale);
  while (boxes.size() < static_cast<std::size_t>(count)) {
    const WorldTriangle w =
        scene.world_triangle({static_cast<std::uint32_t>(random.index(instances)),
                              static_cast<std::uint32_t>(random.index(kTriangles))});
    if (!is_finite(w)) continue;
    const double reach = s * std::exp2(random.integer(-8, 3));
    const auto offset = [&] { return c.grid ? s * random.integer(0, 3) : reach * random.unit(); };
    Box3d box;
    for (int k = 0; k < 3; ++k) {
      // A corner of the box in a corner of the triangle, every third time.
      const double at = random.chance(0.3) ? w.v0[k] : w.v1[k] + reach * random.between(-1, 1);
      box.min[k] = at - (random.chance(0.5) ? 0 : offset());
      box.max[k] = at + (random.chance(0.5) ? 0 : offset());
    }
    switch (random.integer(0, 7)) {
      case 0:
        box.min[random.integer(0, 2)] = -kInf;
        box.max[random.integer(0, 2)] = kInf;
        break;
      case 1:
        box = {w.v2, w.v2};
        break;
      case 2:
        box = {{-kInf, -kInf, -kInf}, {kInf, kInf, kInf}};
        break;
      case 3:
      case 4:
      case 5: {
        OrientedBox oriented;
        oriented.center = w.v0;
        oriented.half = {offset(), offset(), offset()};
        const Vec3d q = random.direction();
        const double angle = random.between(0, 3);
        const double sine = std::sin(angle);
        oriented.axes = rotated_axes(q.x * sine, q.y * sine, q.z * sine, std::cos(angle));
        if (random.chance(0.3)) oriented.axes = {{{1, 1, 0}, {1, -1, 0}, {0, 1, 2}}};
        if (random.chance(0.1)) oriented.half[random.integer(0, 2)] = kInf;
        boxes.push_back(oriented);
        continue;
      }
      default:
        break;
    }
    boxes.push_back(box);
  }
  BoxFault fault;
  EXPECT_TRUE(check_boxes(boxes, fault)) << fault.code;
  return boxes;
}

TEST(BoxOverlaps, finds_what_the_exact_predicate_finds_one_by_one) {
  constexpr std::uint64_t kSeed = 55;
  for (const Case& c : cases()) {
    Random random(kSeed);
    std::size_t found = 0;
    for (int round = 0; round < 4; ++round) {
      const auto scene = make_scene(c, random);
      const BoxBatch boxes = make_boxes(c, *scene, random, 60);
      const Deadline deadline = Deadline::never();
      BoxOverlaps overlaps(*scene, deadline);
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        std::vector<TriangleId> expected;
        std::set<std::uint32_t> nodes;
        for (std::uint32_t instance = 0; instance < scene->description().instances.size();
             ++instance) {
          for (std::uint32_t triangle = 0; triangle < kTriangles; ++triangle) {
            const WorldTriangle w = scene->world_triangle({instance, triangle});
            if (!boxes.visit(i,
                             [&](const auto& box) { return triangle_meets_box(w, prepared(box)); }))
              continue;
            expected.push_back({instance, triangle});
            nodes.insert(scene->description().instances[instance].node);
          }
        }
        found += expected.size();
        ASSERT_EQ(overlaps.list(boxes, i, BoxTargets::kTriangles, 1000000), expected.size())
            << c.name << " seed " << kSeed << " round " << round << " box " << i;
        ASSERT_EQ(overlaps.triangles(), expected) << c.name;
        ASSERT_EQ(overlaps.any(boxes, i), !expected.empty()) << c.name;
        // A limit keeps the smallest ids, and the total.
        ASSERT_EQ(overlaps.list(boxes, i, BoxTargets::kTriangles, 5), expected.size());
        expected.resize(std::min<std::size_t>(expected.size(), 5));
        ASSERT_EQ(overlaps.triangles(), expected) << c.name;
        ASSERT_EQ(overlaps.list(boxes, i, BoxTargets::kNodes, 1000000), nodes.size());
        ASSERT_EQ(overlaps.nodes(), std::vector<std::uint32_t>(nodes.begin(), nodes.end()));
      }
    }
    EXPECT_GT(found, 1000u) << c.name;
  }
}

/// 1e-300 times 1e-36, the way into the mesh, is nothing in float64; 1e306 times it is 1e-30.
TEST(BoxOverlaps, axes_that_vanish_in_a_tree_still_span_a_box) {
  const Affine larger = test::affine({1e36, 0, 0, 0, 0, 1e36, 0, 0, 0, 0, 1e36, 0});
  Random random(58);
  const auto scene =
      make_scene({"long", 1e-30f, 0, false, {larger, larger}, Joining::kNever}, random);
  BoxBatch boxes;
  for (int axis = 0; axis < 3; ++axis) {
    OrientedBox box;
    box.half = {1e7, 1e7, 1e7};
    box.half[axis] = 1e307;
    box.axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    box.axes[static_cast<std::size_t>(axis)][axis] = 1e300;
    boxes.push_back(box);
  }
  const Deadline deadline = Deadline::never();
  BoxOverlaps overlaps(*scene, deadline);
  // Both placements, wholly inside, but for what has no area or no place.
  std::size_t expected = 0;
  for (std::uint32_t i = 0; i < kTriangles; ++i) {
    const WorldTriangle w = scene->world_triangle({0, i});
    expected += triangle_meets_box(w, Box3d{{-1e7, -1e7, -1e7}, {1e7, 1e7, 1e7}}) ? 2u : 0u;
  }
  EXPECT_GT(expected, 200u);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    EXPECT_EQ(overlaps.list(boxes, i, BoxTargets::kTriangles, 1), expected) << "axis " << i;
  }
}

TEST(BoxOverlaps, finds_what_spheres_meet) {
  for (const Case& c : cases()) {
    Random random(67);
    const auto scene = make_scene(c, random);
    std::size_t found = 0;
    BoxBatch boxes;
    while (boxes.size() < 60) {
      const WorldTriangle w = scene->world_triangle(
          {static_cast<std::uint32_t>(random.index(scene->description().instances.size())),
           static_cast<std::uint32_t>(random.index(kTriangles))});
      const Vec3d edge{w.v1.x - w.v0.x, w.v1.y - w.v0.y, w.v1.z - w.v0.z};
      Sphere sphere{w.v0, std::fabs(edge.x) + std::fabs(edge.y) + std::fabs(edge.z)};
      sphere.radius *= random.between(0, 2);
      BoxBatch one;
      one.push_back(sphere);
      BoxFault fault;
      if (check_boxes(one, fault)) boxes.push_back(sphere);
    }
    const Deadline deadline = Deadline::never();
    BoxOverlaps overlaps(*scene, deadline);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      std::vector<TriangleId> expected;
      for (std::uint32_t instance = 0; instance < scene->description().instances.size();
           ++instance) {
        for (std::uint32_t triangle = 0; triangle < kTriangles; ++triangle) {
          if (triangle_meets_box(scene->world_triangle({instance, triangle}), boxes.spheres[i]))
            expected.push_back({instance, triangle});
        }
      }
      found += expected.size();
      ASSERT_EQ(overlaps.list(boxes, i, BoxTargets::kTriangles, 1000000), expected.size());
      ASSERT_EQ(overlaps.triangles(), expected) << c.name << " sphere " << i;
    }
    EXPECT_GT(found, 300u) << c.name;
  }
}

TEST(BoxOverlaps, finds_what_capsules_and_regions_meet_and_hold) {
  for (const Case& c : cases()) {
    Random random(68);
    const auto scene = make_scene(c, random);
    const auto instances = scene->description().instances.size();
    BoxBatch boxes;
    while (boxes.size() < 16) {
      const auto w = [&] {
        return scene->world_triangle({static_cast<std::uint32_t>(random.index(instances)),
                                      static_cast<std::uint32_t>(random.index(kTriangles))});
      };
      const WorldTriangle a = w(), b = w();
      BoxBatch one;
      std::vector<Vec3d> points;
      if (random.chance(0.3)) {
        for (std::size_t k = random.index(6) + 1; k > 0; --k) {
          const WorldTriangle other = w();
          points.push_back(random.chance(0.5) ? other.v0 : random.chance(0.5) ? a.v1 : b.v2);
        }
        one.push_back(PointHull{points});
      } else if (random.chance(0.5)) {
        one.push_back(Capsule{a.v0, b.v1, std::fabs(a.v1.x - a.v0.x) * random.between(0, 2)});
      } else {
        // Planes through corners: some wedge, slab or prism, often between two triangles.
        std::vector<HalfSpace> planes(random.index(7) + 1);
        for (HalfSpace& plane : planes) {
          plane.normal = random.chance(0.5) ? Vec3d{1, 0, 0} : random.direction();
          const Vec3d& p = random.chance(0.5) ? a.v0 : b.v2;
          const double n = random.chance(0.5) ? 1 : -1;
          for (int k = 0; k < 3; ++k) plane.normal[k] *= n;
          plane.offset = plane.normal.x * p.x + plane.normal.y * p.y + plane.normal.z * p.z;
        }
        one.push_back(ConvexRegion{planes});
      }
      BoxFault fault;
      if (!check_boxes(one, fault)) continue;
      one.visit(0, [&](const auto& shape) {
        if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, Capsule> ||
                      std::is_same_v<std::decay_t<decltype(shape)>, ConvexRegion> ||
                      std::is_same_v<std::decay_t<decltype(shape)>, PointHull>) {
          boxes.push_back(shape);
        }
      });
    }
    const Deadline deadline = Deadline::never();
    BoxOverlaps overlaps(*scene, deadline);
    std::size_t met = 0, held = 0;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      std::vector<TriangleId> meeting, within;
      std::set<std::uint32_t> nodes, beyond;
      for (std::uint32_t instance = 0; instance < instances; ++instance) {
        const std::uint32_t node = scene->description().instances[instance].node;
        for (std::uint32_t triangle = 0; triangle < kTriangles; ++triangle) {
          const WorldTriangle w = scene->world_triangle({instance, triangle});
          if (!is_finite(w) || is_degenerate(w)) continue;
          boxes.visit(i, [&](const auto& given) {
            const auto& shape = prepared(given);
            if (triangle_meets_box(w, shape)) meeting.push_back({instance, triangle});
            const bool inside = corners_within(w, shape);
            if (inside) within.push_back({instance, triangle});
            (inside ? nodes : beyond).insert(node);
          });
        }
      }
      std::erase_if(nodes, [&](std::uint32_t node) { return beyond.count(node) > 0; });
      overlaps.list(boxes, i, BoxTargets::kTriangles, 1000000);
      ASSERT_EQ(overlaps.triangles(), meeting) << c.name << " shape " << i;
      overlaps.list(boxes, i, BoxTargets::kTriangles, 1000000, BoxRelation::kContained);
      ASSERT_EQ(overlaps.triangles(), within) << c.name << " shape " << i;
      ASSERT_EQ(overlaps.any(boxes, i, BoxRelation::kContained), !within.empty()) << c.name;
      overlaps.list(boxes, i, BoxTargets::kNodes, 1000000, BoxRelation::kContained);
      ASSERT_EQ(overlaps.nodes(), std::vector<std::uint32_t>(nodes.begin(), nodes.end())) << c.name;
      // In pieces, the same.
      std::vector<TriangleId> pieces;
      std::uint64_t from = 0;
      do {
        overlaps.list(boxes, i, BoxTargets::kTriangles, 97, BoxRelation::kIntersecting, from);
        pieces.insert(pieces.end(), overlaps.triangles().begin(), overlaps.triangles().end());
        from = overlaps.next();
      } while (from != 0);
      ASSERT_EQ(pieces, meeting) << c.name << " shape " << i;
      met += meeting.size();
      held += within.size();
    }
    std::printf("%s: met %zu, held %zu\n", c.name, met, held);
    EXPECT_GT(met, 100u) << c.name;
  }
}

TEST(BoxOverlaps, agrees_with_the_oracle) {
  for (const Case& c : cases()) {
    Random random(56);
    const auto scene = make_scene(c, random);
    const BoxBatch boxes = make_boxes(c, *scene, random, 12);
    const oracle::WorldTriangles world(*scene);
    const Deadline deadline = Deadline::never();
    BoxOverlaps overlaps(*scene, deadline);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const oracle::ExactBox box =
          boxes.is_aligned(i)
              ? oracle::axis_aligned(boxes.aligned[i])
              : oracle::oriented_by_slabs(boxes.oriented_boxes[boxes.oriented[i]].center,
                                          boxes.oriented_boxes[boxes.oriented[i]].axes,
                                          boxes.oriented_boxes[boxes.oriented[i]].half);
      std::vector<TriangleId> expected;
      for (std::size_t t = 0; t < world.triangles.size(); ++t) {
        const oracle::Triangle& w = world.triangles[t];
        if (oracle::is_finite(w) && !oracle::has_no_area(w) && oracle::overlap(box, w)) {
          expected.push_back(world.id(t));
        }
      }
      overlaps.list(boxes, i, BoxTargets::kTriangles, 1000000);
      ASSERT_EQ(overlaps.triangles(), expected) << c.name << " box " << i;
    }
  }
}

TEST(BoxOverlaps, visits_little_of_a_large_scene_for_a_small_box) {
  Random random(57);
  auto mesh = std::make_shared<Mesh>();
  for (std::uint32_t i = 0; i < 30000; ++i) {
    const Vec3d p = random.point(-100, 100);
    for (int corner = 0; corner < 3; ++corner) {
      const Vec3d d = random.point(-0.5, 0.5);
      mesh->positions.own().push_back({static_cast<float>(p.x + d.x), static_cast<float>(p.y + d.y),
                                       static_cast<float>(p.z + d.z)});
      mesh->indices.own().push_back(3 * i + static_cast<std::uint32_t>(corner));
    }
  }
  mesh->primitives.push_back({0, 30000, 0, 0xffffffffu});
  SceneDescription description;
  description.meshes.push_back(mesh);
  description.nodes.push_back({});
  description.instances.push_back({});
  const auto scene = *Scene::build(std::move(description));
  BoxBatch boxes;
  boxes.push_back(Box3d{{-5, -5, -5}, {5, 5, 5}});
  // A long thin diagonal box: its bounds hold the whole scene, its slabs do not.
  const double r = std::sqrt(0.5);
  boxes.push_back(OrientedBox{{0, 0, 0}, {100, 1, 1}, {{{r, r, 0}, {-r, r, 0}, {0, 0, 1}}}});
  const Deadline deadline = Deadline::never();
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    BoxOverlaps overlaps(*scene, deadline);
    EXPECT_GT(overlaps.list(boxes, i, BoxTargets::kTriangles, 0), 0u);
    EXPECT_LT(overlaps.counts().triangles, 1000u);
    EXPECT_LT(overlaps.counts().nodes, 300u);
  }
}

TEST(BoxOverlaps, stops_when_the_deadline_passes) {
  Random random(58);
  const auto scene = make_scene(cases()[4], random);
  BoxBatch boxes;
  boxes.push_back(Box3d{{-kInf, -kInf, -kInf}, {kInf, kInf, kInf}});
  CancelFlag flag;
  flag.cancel();
  const Deadline deadline = Deadline::in(std::chrono::hours(1), &flag);
  BoxOverlaps overlaps(*scene, deadline);
  for (int i = 0; i < 10 && !overlaps.stopped(); ++i) {
    overlaps.list(boxes, 0, BoxTargets::kTriangles, 10);
  }
  EXPECT_TRUE(overlaps.stopped());
}

TEST(BoxRegion, bounds_an_oriented_box_from_outside) {
  Random random(59);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d q = random.direction();
    const double angle = random.between(0, 3), sine = std::sin(angle);
    OrientedBox box{random.point(-10, 10), random.point(0, 4),
                    rotated_axes(q.x * sine, q.y * sine, q.z * sine, std::cos(angle))};
    const Box3d bounds = outer_bounds(box);
    // A triangle at the very corner of the bounds' outside must not meet the box.
    for (int k = 0; k < 3; ++k) {
      Box3d beyond{{-kInf, -kInf, -kInf}, {kInf, kInf, kInf}};
      beyond.min[k] = bounds.max[k];
      const double gap = bounds.max[k] - bounds.min[k];
      EXPECT_LE(gap, 2 * (box.half.x + box.half.y + box.half.z) * 1.000001);
      Triangle wall{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
      wall.v0[k] = wall.v1[k] = wall.v2[k] = bounds.max[k];
      wall.v1[(k + 1) % 3] = 1e6;
      wall.v2[(k + 2) % 3] = 1e6;
      wall.v0[(k + 1) % 3] = wall.v0[(k + 2) % 3] = -2e6;
      EXPECT_FALSE(triangle_meets_box(wall, box));
    }
  }
  const Box3d open =
      outer_bounds(OrientedBox{{0, 0, 0}, {1, kInf, 1}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}});
  EXPECT_EQ(open.max.y, kInf);
  const Box3d singular =
      outer_bounds(OrientedBox{{0, 0, 0}, {1, 1, 1}, {{{1, 0, 0}, {1, 1e-30, 0}, {0, 0, 1}}}});
  EXPECT_EQ(singular.max.y, kInf);
}

}  // namespace
}  // namespace sightline
