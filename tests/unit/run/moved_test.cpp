// Scenes of which some nodes have moved: the bytes of a scene that was loaded so, from the trees
// that were there before.

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/infinity.h"
#include "core/demo/random.h"
#include "core/scene/edited_nodes.h"
#include "core/scene/poser.h"
#include "tests/support/random_cases.h"
#include "tests/unit/run/golden_answers.h"

namespace sightline {
namespace {

using demo::DemoScene;
using test::ask;
using test::description_of;
using test::engine_of;
using test::rays_into;
using test::scene_of;

/// A turn, a stretch, a reflection, or, of small scenes (rays in a plane of many triangles take
/// long), what flattens everything.
Affine any_matrix(demo::Random& random, double width, bool is_small) {
  const Affine to = demo::translation(random.between(-width, width), random.between(-width, width),
                                      random.between(-width, width));
  switch (random.below(is_small ? 5 : 2)) {
    case 0:
      return to;
    case 1:
      return to * demo::scaling(random.spread(0.1, 10), -random.spread(0.1, 10), 1);
    case 2:
      return to * demo::scaling(1, 0, 1);
    default:
      return to * demo::random_rotation(random) * demo::scaling(random.spread(0.5, 2), 1, 1);
  }
}

std::uint64_t answers_of(const Scene& scene, const RayBatch& rays) {
  const auto engine = engine_of("", 1);
  std::uint64_t hash = ask(*engine, scene, rays).hash();
  Column<Vec3d> points;
  BoxBatch boxes;
  for (std::size_t i = 0; i < 60; ++i) {
    const Vec3d at = rays[i].origin;
    points.push_back(at);
    boxes.push_back(Box3d{at, {at.x + 9, at.y + 9, at.z + 9}});
  }
  HitBatch nearest;
  EXPECT_TRUE(engine->nearest(scene, points, kInf, 3, Deadline::never(), nearest));
  Column<std::uint64_t> totals;
  EXPECT_TRUE(engine->boxes_count(scene, boxes, BoxTargets::kNodes, Deadline::never(), totals));
  for (const std::uint64_t each :
       {test::hash_column(nearest.t), test::hash_column(nearest.instance),
        test::hash_column(nearest.triangle), test::hash_column(totals)}) {
    hash = test::combine(hash, each);
  }
  return hash;
}

void expect_moves(DemoScene demo_scene, std::shared_ptr<const Scene> scene, std::uint64_t seed,
                  int rounds = 4) {
  demo::Random random(seed);
  NodeChanges all;
  for (int round = 0; round < test::random_cases(rounds); ++round) {
    NodeChanges changes;
    for (std::uint32_t k = 0; k <= random.below(4); ++k) {
      NodeChange change;
      change.node = random.below(static_cast<std::uint32_t>(demo_scene.nodes.size()));
      if (random.below(3) == 0) {
        change.hidden = random.below(3) != 0;
      } else {
        change.parent_from_node = any_matrix(random, 20, demo_scene.nodes.size() > 1);
        demo_scene.nodes[change.node].parent_from_node = *change.parent_from_node;
      }
      changes = with_changes(std::move(changes), std::span(&change, 1));
      all = with_changes(std::move(all), std::span(&change, 1));
    }
    auto next = scene->changed(changes);
    ASSERT_TRUE(next.ok()) << next.error().message;
    SceneDescription loaded = description_of(demo_scene);
    ASSERT_TRUE(change_nodes(loaded, all).ok());
    const auto fresh = *Scene::prepare(std::move(loaded));
    EXPECT_EQ((*next)->bounds(), fresh->bounds());
    scene = *next;
    if (fresh->bounds().empty()) continue;  // all is hidden
    const RayBatch rays = rays_into(*fresh);
    EXPECT_EQ(answers_of(**next, rays), answers_of(*fresh, rays))
        << "seed " << seed << ", round " << round;
    EXPECT_EQ((*next)->trees().stats().full_builds, 0u);
  }
}

TEST(MovedScene, answers_as_one_that_was_loaded_so) {
  for (const std::uint64_t seed : {1u, 2u}) {
    expect_moves(demo::town(), scene_of(demo::town()), seed);
    const DemoScene shared = demo::instances(60, 400);
    expect_moves(shared, *Scene::build(description_of(shared), TreeQuality::kFast, Joining::kNever),
                 seed);
    expect_moves(demo::six_triangles(), scene_of(demo::six_triangles()), seed);
  }
}

TEST(MovedScene, answers_so_before_its_trees_are_built) {
  expect_moves(demo::town(), *Scene::prepare(description_of(demo::town())), 7);
  const DemoScene large = demo::terrain(150000);  // enough to be cut into parts
  expect_moves(large, *Scene::prepare(description_of(large)), 8, 2);
}

/// Stretches the mesh of an instance along x by the weight of its node.
class Stretcher : public Poser {
 public:
  explicit Stretcher(const SceneDescription& scene) {
    for (const Instance& instance : scene.instances) base_.push_back(scene.meshes[instance.mesh]);
  }
  Result<PosedMeshes> pose(SceneDescription& scene, const PoseChange& change) const override {
    PosedMeshes posed;
    std::vector<std::uint32_t> uses(scene.meshes.size());
    for (const Instance& instance : scene.instances) ++uses[instance.mesh];
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
      Instance& instance = scene.instances[i];
      if (!change.weighted[instance.node]) continue;
      auto mesh = std::make_shared<Mesh>(*base_[i]);
      const double stretch = (*scene.nodes[instance.node].weights)[0];
      for (Vec3f& at : mesh->positions.own()) at.x = static_cast<float>(at.x * stretch);
      if (--uses[instance.mesh] > 0) {
        instance.mesh = static_cast<std::uint32_t>(scene.meshes.size());
        scene.meshes.emplace_back();
      }
      scene.meshes[instance.mesh] = std::move(mesh);
      posed.fresh.push_back(instance.mesh);
      posed.instances.push_back(i);
    }
    std::sort(posed.fresh.begin(), posed.fresh.end());
    return posed;
  }
  Result<std::vector<NodeChange>> sample(const AnimationTime&) const override { return none(); }
  Result<std::vector<AnimationSummary>> animations() const override { return none(); }
  std::uint64_t bytes() const override { return 0; }
  std::uint64_t bytes_of_call() const override { return 0; }

 private:
  static Error none() { return {ErrorKind::kInvalid, "ANIMATION_UNKNOWN", "there is none", ""}; }
  std::vector<std::shared_ptr<const Mesh>> base_;
};

SceneDescription with_stretcher(SceneDescription scene) {
  for (Node& node : scene.nodes) node.morph_targets = 1;
  scene.poser = std::make_shared<const Stretcher>(scene);
  return scene;
}

/// A changed scene, and one that was loaded so: bounds and answers are equal, and not all trees were
/// built again.
void expect_equal(const Scene& changed, const Scene& loaded, const std::string& what) {
  EXPECT_EQ(changed.bounds(), loaded.bounds()) << what;
  if (loaded.bounds().empty()) return;
  const RayBatch rays = rays_into(loaded);
  EXPECT_EQ(answers_of(changed, rays), answers_of(loaded, rays)) << what;
  EXPECT_EQ(changed.trees().stats().full_builds, 0u) << what;
}

void expect_poses(const DemoScene& demo_scene, std::shared_ptr<const Scene> scene,
                  std::uint64_t seed) {
  demo::Random random(seed);
  NodeChanges all;
  for (int round = 0; round < test::random_cases(4); ++round) {
    NodeChanges changes;
    for (std::uint32_t k = 0; k <= random.below(4); ++k) {
      NodeChange change;
      change.node = random.below(static_cast<std::uint32_t>(demo_scene.nodes.size()));
      switch (random.below(4)) {
        case 0:
          change.parent_from_node = demo::translation(random.between(-9, 9), 0, 0);
          break;
        case 1:
          change.hidden = random.below(3) == 0;
          break;
        default:
          // Two of them may be equal.
          change.weights = {0.5 * (1 + random.below(3))};
      }
      changes = with_changes(std::move(changes), std::span(&change, 1));
    }
    all = with_changes(std::move(all), changes);
    auto next = scene->changed(changes);
    ASSERT_TRUE(next.ok()) << next.error().message;
    SceneDescription loaded = with_stretcher(description_of(demo_scene));
    ASSERT_TRUE(change_nodes(loaded, all).ok());
    const auto fresh = *Scene::prepare(std::move(loaded));
    expect_equal(**next, *fresh,
                 "seed " + std::to_string(seed) + ", round " + std::to_string(round));
    scene = *next;
  }
}

TEST(PosedScene, answers_as_one_that_was_loaded_so) {
  for (const DemoScene& demo_scene :
       {demo::town(), demo::instances(60, 400), demo::six_triangles()}) {
    expect_poses(demo_scene, *Scene::prepare(with_stretcher(description_of(demo_scene))), 1);
    expect_poses(demo_scene,
                 *Scene::build(with_stretcher(description_of(demo_scene)), TreeQuality::kFast), 11);
  }
}

TEST(PosedScene, keeps_the_trees_of_meshes_that_it_does_not_pose) {
  const auto scene = *Scene::build(with_stretcher(description_of(demo::six_triangles())));
  const auto engine = engine_of("", 1);
  RayBatch rays;
  rays.push_back({{-10, 1, 0}, {1, 0, 0}});
  rays.push_back({{3, 10, 0}, {0, -1, 0}});
  HitBatch hits;
  ASSERT_TRUE(engine->closest(*scene, rays, Deadline::never(), hits));
  const double before = hits.t[1];
  const auto posed = *scene->changed(NodeChanges{{1, {}, {}, {}, {0.5}}});
  ASSERT_TRUE(engine->closest(*posed, rays, Deadline::never(), hits));
  EXPECT_EQ(hits.t[1], before);
  EXPECT_EQ(posed->trees().stats().trees_kept, 1u);
  EXPECT_EQ(posed->trees().stats().trees_built, 1u);
  EXPECT_EQ(posed->trees().geometry(), scene->trees().geometry());
  EXPECT_EQ(scene->changed(NodeChanges{{1, {}, {}, {}, {1, 2}}}).error().code,
            "NODE_WEIGHTS_WRONG");
}

TEST(MovedScene, builds_the_tree_of_a_mesh_that_leaves_the_others_once) {
  const auto scene = scene_of(demo::six_triangles());
  const auto engine = engine_of("", 1);
  RayBatch rays;
  rays.push_back({{3, 10, 0}, {0, -1, 0}});
  HitBatch hits;
  std::shared_ptr<const Scene> moved = scene;
  for (const double up : {1.0, 2.0, 3.0}) {
    moved = *moved->changed(NodeChanges{{2, demo::translation(0, up, 0), {}, {}}});
    ASSERT_TRUE(engine->closest(*moved, rays, Deadline::never(), hits));
    EXPECT_EQ(hits.t[0], 8 - up);
    EXPECT_EQ(moved->trees().stats().trees_built, up == 1 ? 1u : 0u);
    EXPECT_EQ(moved->trees().stats().full_builds, 0u);
  }
  ASSERT_TRUE(engine->closest(*scene, rays, Deadline::never(), hits));
  EXPECT_EQ(hits.t[0], 8);
}

TEST(MovedScene, keeps_numbers_and_shows_again_what_was_hidden) {
  const auto scene = scene_of(demo::six_triangles());
  const auto engine = engine_of("", 1);
  RayBatch rays;
  rays.push_back({{-10, 1, 0}, {1, 0, 0}});
  HitBatch hits;
  const auto without_left = *scene->changed(NodeChanges{{1, {}, true, {}}});
  ASSERT_TRUE(engine->closest(*without_left, rays, Deadline::never(), hits));
  EXPECT_EQ(hits.t[0], 12.5);
  EXPECT_EQ(hits.instance[0], 1u);
  const auto without_any = *without_left->changed(NodeChanges{{0, {}, true, {}}});
  ASSERT_TRUE(engine->closest(*without_any, rays, Deadline::never(), hits));
  EXPECT_FALSE(hits.hit(0));
  EXPECT_TRUE(without_any->bounds().empty());
  const auto again = *without_any->changed(NodeChanges{{0, {}, false, {}}, {1, {}, false, {}}});
  ASSERT_TRUE(engine->closest(*again, rays, Deadline::never(), hits));
  EXPECT_EQ(hits.t[0], 4.5);
}

/// The positions of an instance's mesh, stretched along x.
SharedColumn<Vec3f> stretched(const SceneDescription& scene, const Instance& instance, float by) {
  const auto& positions = scene.meshes[instance.mesh]->positions;
  UnsetColumn<Vec3f> made(positions.begin(), positions.end());
  for (Vec3f& each : made) each.x *= by;
  return SharedColumn<Vec3f>::shared(std::move(made));
}

/// Adds copies, removes nodes, moves what is there and gives it other vertices, all at random.
void expect_edits(const DemoScene& demo_scene, std::shared_ptr<const Scene> scene,
                  std::uint64_t seed) {
  demo::Random random(seed);
  NodeChanges all;
  for (int round = 0; round < test::random_cases(6); ++round) {
    NodeChanges changes;
    const auto& nodes = scene->description().nodes;
    const auto some_node = [&](bool with_mesh) -> std::optional<std::uint32_t> {
      for (int tries = 0; tries < 50; ++tries) {
        const std::uint32_t node = random.below(static_cast<std::uint32_t>(nodes.size()));
        const std::span instances(scene->description().instances);
        if (nodes[node].removed || (with_mesh && instances_of(instances, node).empty())) continue;
        return nodes[node].file_node;
      }
      return {};
    };
    for (std::uint32_t k = 0; k <= random.below(4); ++k) {
      const std::uint32_t kind = random.below(5);
      const auto node = some_node(kind < 2 || kind == 4);
      if (!node) continue;
      NodeChange change;
      change.node = kind < 2 ? 1000000 + 10 * static_cast<std::uint32_t>(round) + k : *node;
      if (kind < 2)
        change.added = AddedNode{*node, random.below(2) == 0 ? some_node(false) : std::nullopt};
      change.removed = kind == 2 && nodes.size() > 2;
      const auto& description = scene->description();
      if (kind == 4) {
        const auto found = numbers_of(description).at(*node);
        const auto instances = instances_of(std::span(description.instances), found);
        change.positions = stretched(
            description, instances.front(),
            random.below(3) == 0 ? -1.0f : 0.5f * static_cast<float>(1 + random.below(3)));
      } else if (!change.removed) {
        change.parent_from_node = any_matrix(random, 20, nodes.size() > 1);
      }
      changes = with_changes(std::move(changes), std::span(&change, 1));
    }
    const auto resolved = resolve(scene->description(), {{}, changes});
    ASSERT_TRUE(resolved.ok()) << resolved.error().message;
    auto next = scene->changed(resolved->nodes);
    ASSERT_TRUE(next.ok()) << next.error().message;
    all = with_changes(std::move(all), resolved->nodes);
    forget_removed((*next)->description(), all);
    SceneDescription loaded = description_of(demo_scene);
    ASSERT_TRUE(change_nodes(loaded, all).ok());
    const auto fresh = *Scene::prepare(std::move(loaded));
    expect_equal(**next, *fresh,
                 "seed " + std::to_string(seed) + ", round " + std::to_string(round));
    EXPECT_EQ((*next)->counts().nodes, fresh->counts().nodes);
    EXPECT_EQ((*next)->counts().meshes, fresh->counts().meshes);
    EXPECT_EQ((*next)->unique_triangle_count(), fresh->unique_triangle_count());
    scene = *next;
  }
}

TEST(EditedScene, answers_as_one_that_was_loaded_so) {
  for (const DemoScene& demo_scene :
       {demo::town(), demo::instances(60, 400), demo::six_triangles()}) {
    expect_edits(demo_scene, *Scene::prepare(description_of(demo_scene)), 1);
    expect_edits(demo_scene, scene_of(demo_scene), 11);
  }
}

TEST(EditedScene, gives_a_node_vertices_of_its_own_and_shares_what_is_equal) {
  const auto scene = scene_of(demo::six_triangles());
  const SceneDescription& before = scene->description();
  NodeChange add{9, {}, {}, {}, {}, AddedNode{2, {}}};
  NodeChange change{2, {}, {}, {}};
  change.positions = stretched(before, before.instances[1], 2);
  const auto changes = resolve(before, {{}, {add, change}});
  const auto edited = *scene->changed(changes->nodes);
  EXPECT_EQ(edited->counts().meshes, 3u);
  EXPECT_EQ(edited->description().meshes[0], before.meshes[0]);
  EXPECT_EQ(edited->description().meshes[1], before.meshes[1]) << "that of the copy";
  EXPECT_EQ(edited->description().instances[1].mesh, 2u);
  EXPECT_EQ(edited->trees().stats().full_builds, 0u);
  // The file's positions again: then both share the file's mesh.
  change.positions = stretched(before, before.instances[1], 1);
  const auto back = *edited->changed(NodeChanges{change});
  EXPECT_EQ(back->description().meshes, before.meshes);
  // A copy of a node with other positions has these, whatever becomes of that node.
  change.positions = stretched(before, before.instances[1], 3);
  add.node = 10;
  const auto copied = resolve(before, {{}, {change, add}});
  EXPECT_EQ(copied->nodes[1].positions, change.positions);
  EXPECT_EQ((*scene->changed(copied->nodes))->counts().meshes, 2u);
  change.positions = {{0, 0, 0}};
  EXPECT_EQ(scene->changed(NodeChanges{change}).error().code, "NODE_POSITIONS_WRONG");
}

TEST(EditedScene, keeps_all_numbers_and_frees_what_nothing_shows) {
  const auto scene = scene_of(demo::six_triangles());
  NodeChange add{9, {}, {}, {}, {}, AddedNode{2, 0, "more"}};
  NodeChange remove{2, {}, {}, {}};
  remove.removed = true;
  const auto more = *scene->changed(NodeChanges{add});
  EXPECT_EQ(more->instanced_triangle_count(), 9u);
  EXPECT_EQ(more->description().meshes, scene->description().meshes);
  EXPECT_EQ(more->trees().geometry(), scene->trees().geometry());
  const auto fewer = *more->changed(NodeChanges{remove});
  EXPECT_EQ(fewer->instanced_triangle_count(), 6u);
  EXPECT_EQ(fewer->unique_triangle_count(), 6u);
  EXPECT_EQ(fewer->description().instances.size(), 3u);
  EXPECT_FALSE(fewer->find_triangle({1, 0, 0}));
  EXPECT_TRUE(fewer->find_triangle({2, 0, 0}));
  remove.node = 9;
  const auto left = *fewer->changed(NodeChanges{remove});
  EXPECT_EQ(left->unique_triangle_count(), 3u);
  EXPECT_EQ(left->counts().meshes, 1u);
  EXPECT_EQ(left->changed(NodeChanges{add}).error().code, "NODE_EXISTS");
  EXPECT_EQ(left->changed(NodeChanges{remove}).error().code, "NODE_NOT_FOUND");
}

TEST(MovedScene, refuses_what_is_no_node_or_too_large) {
  const auto scene = scene_of(demo::six_triangles());
  EXPECT_EQ(scene->changed(NodeChanges{{77, {}, true, {}}}).error().code, "NODE_NOT_FOUND");
  const auto huge = demo::scaling(1e30, 1, 1);
  EXPECT_EQ(scene->changed(NodeChanges{{0, huge, {}, {}}, {1, huge, {}, {}}}).error().code,
            "TRANSFORM_INVALID");
}

}  // namespace
}  // namespace sightline
