// A sound tree passes; a tree that is damaged in any one way is refused with the place and reason.

#include "core/bvh/validate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <random>

#include "core/bvh/triangle_tree.h"
#include "tests/unit/bvh/test_mesh.h"

namespace sightline {
namespace {

WideTree copy_of(const WideTree& tree, std::size_t bytes) {
  WideTree copy;
  copy.arena = Arena(bytes);
  copy.arena.take(bytes);
  // An empty arena has no address to copy to.
  if (bytes > 0) {
    std::memcpy(copy.arena.at(0), tree.arena.at(0), std::min(bytes, tree.arena.used()));
  }
  copy.root = tree.root;
  copy.scale_exponent = tree.scale_exponent;
  copy.bounds = tree.bounds;
  copy.node_count = tree.node_count;
  copy.block_count = tree.block_count;
  copy.depth = tree.depth;
  return copy;
}

std::vector<std::byte> bytes_of(const LeafBlock& block) {
  const auto* first = reinterpret_cast<const std::byte*>(&block);
  return {first, first + block.granules() * Arena::kGranule};
}

std::string reason(const Status& status) { return status ? "sound" : status.error().message; }

class DamagedTree : public testing::Test {
 protected:
  DamagedTree() : tree_(build_triangle_tree(mesh_.view(), nullptr, TreeQuality::kFast)) {}

  /// Takes a mesh whose triangles share vertices, and its tree.
  void use_terrain() {
    mesh_ = TestMesh(demo::terrain(1000).meshes[0]);
    tree_ = build_triangle_tree(mesh_.view(), nullptr, TreeQuality::kFast);
  }

  WideNode& node(std::uint32_t ref) { return *reinterpret_cast<WideNode*>(tree_.arena.at(ref)); }
  WideNode& root() { return node(tree_.root); }
  /// The first leaf in a depth-first walk, and where its reference stands.
  std::uint32_t& leaf_ref(std::size_t number = 0) {
    std::vector<std::uint32_t> waiting{tree_.root};
    while (!waiting.empty()) {
      WideNode& at = node(waiting.back());
      waiting.pop_back();
      for (std::uint32_t& child : at.child) {
        if (child == ChildRef::kEmpty) continue;
        if (!ChildRef::is_leaf(child)) {
          waiting.push_back(child);
        } else if (number-- == 0) {
          return child;
        }
      }
    }
    ADD_FAILURE() << "no such leaf";
    return root().child[0];
  }
  LeafBlock& block(std::size_t number = 0) {
    return *reinterpret_cast<LeafBlock*>(tree_.arena.at(ChildRef::granule(leaf_ref(number))));
  }
  /// The node in which a reference stands, and which child of it that is.
  WideNode& owner_of(std::uint32_t& ref) {
    auto* first = reinterpret_cast<std::byte*>(&ref - child_of(ref));
    return *reinterpret_cast<WideNode*>(first - offsetof(WideNode, child));
  }
  std::size_t child_of(const std::uint32_t& ref) const {
    // References fill half a cache line of 64 bytes.
    return reinterpret_cast<std::uintptr_t>(&ref) % 32 / 4;
  }
  std::size_t inner_child() {
    for (std::size_t i = 0; i < kArity; ++i) {
      if (!ChildRef::is_leaf(root().child[i])) return i;
    }
    ADD_FAILURE() << "the root has leaves only";
    return 0;
  }
  std::string reason() const {
    return sightline::reason(validate_triangle_tree(tree_, mesh_.view(), nullptr));
  }
  void expect(const std::string& part) const {
    EXPECT_NE(reason().find(part), std::string::npos) << reason();
  }

  TestMesh mesh_{demo::soup(1000).meshes[0]};
  WideTree tree_;
};

TEST_F(DamagedTree, is_sound_before_the_damage) { EXPECT_EQ(reason(), "sound"); }

TEST_F(DamagedTree, names_the_node_whose_box_is_too_small) {
  const std::size_t i = inner_child();
  root().upper[1][i] = root().lower[1][i];
  expect("the node at granule " + std::to_string(root().child[i]) + ", child ");
  expect("its box leaves the parent's, axis y");
}

TEST_F(DamagedTree, names_the_leaf_whose_triangle_sticks_out) {
  // One step inwards on a plane that the leaf's own triangles reach.
  std::uint32_t& ref = leaf_ref();
  const std::size_t child = child_of(ref);
  owner_of(ref).upper[0][child] = std::nextafterf(owner_of(ref).upper[0][child], -1e30f);
  expect("the leaf at granule " + std::to_string(ChildRef::granule(ref)));
  expect("its box does not contain triangle ");
}

TEST_F(DamagedTree, refuses_boxes_that_are_not_finite_or_inside_out) {
  const float upper = root().upper[2][0];
  root().upper[2][0] = std::numeric_limits<float>::infinity();
  expect("the node at granule 0, child 0: its box is not finite, axis z");
  root().upper[2][0] = std::numeric_limits<float>::quiet_NaN();
  expect("not finite");
  root().upper[2][0] = upper;
  std::swap(root().lower[0][0], root().upper[0][0]);
  expect("its box is inside out, axis x");
}

TEST_F(DamagedTree, refuses_a_cycle) {
  root().child[inner_child()] = tree_.root;
  EXPECT_NE(reason(), "sound");
  // Boxes that would let the walk go round for ever.
  for (std::size_t i = 0; i < kArity; ++i) {
    for (int k = 0; k < 3; ++k) {
      root().lower[k][i] = -1e30f;
      root().upper[k][i] = 1e30f;
    }
  }
  expect("overlaps what was reached another way");
}

TEST_F(DamagedTree, refuses_a_leaf_that_two_nodes_hold) {
  const std::uint32_t other = leaf_ref(1);
  leaf_ref(0) = other;
  EXPECT_NE(reason(), "sound");
}

TEST_F(DamagedTree, refuses_a_subtree_that_nobody_reaches) {
  const std::size_t i = inner_child();
  root().child[i] = ChildRef::kEmpty;
  expect("child " + std::to_string(i) + ": is empty and could be hit");
  for (int k = 0; k < 3; ++k) {
    root().lower[k][i] = std::numeric_limits<float>::infinity();
    root().upper[k][i] = -std::numeric_limits<float>::infinity();
  }
  expect("granules are never reached");
}

TEST_F(DamagedTree, refuses_references_that_leave_the_arena) {
  const auto end = static_cast<std::uint32_t>(tree_.arena.used() / Arena::kGranule);
  const std::size_t i = inner_child();
  for (const std::uint32_t granule : {end - 4, end, end + 2, ChildRef::kGranuleMask - 1}) {
    root().child[i] = granule;
    expect("the node at granule " + std::to_string(granule) + ": needs 8 granules, the arena has ");
    root().child[i] = ChildRef::leaf(granule, 2);
    expect("the leaf at granule " + std::to_string(granule));
    if (granule >= end) expect(": needs 1 granules, the arena has ");
  }
  root().child[i] = 0x40000000u;
  expect("is no place in any arena");
  root().child[i] = 9;
  expect("the node at granule 9: begins within a cache line");
}

TEST_F(DamagedTree, refuses_an_order_that_forgets_a_child) {
  const std::uint32_t good = root().order[5];
  root().order[5] = good & ~7u;
  if (root().order[5] == good) root().order[5] = good | 1u;
  expect("the node at granule 0: the order of octant 5 does not name every child");
  root().order[5] = good | 1u << 24;
  expect("octant 5");
}

TEST_F(DamagedTree, refuses_blocks_that_do_not_hold_what_the_mesh_has) {
  use_terrain();
  const LeafBlock good = block();
  const std::vector<std::byte> bytes = bytes_of(block());
  const std::string leaf = "the leaf at granule " + std::to_string(ChildRef::granule(leaf_ref()));
  const auto damage = [&](const std::function<void(LeafBlock&)>& how, const std::string& why) {
    how(block());
    expect(leaf);
    expect(why);
    std::memcpy(&block(), bytes.data(), bytes.size());
  };
  for (const std::uint32_t lanes : {0u, 5u}) {
    damage([&](LeafBlock& b) { b.set_names(b.triangles(), lanes, 0); },
           "a block has " + std::to_string(lanes) + " lanes");
  }
  const auto name = [&](std::size_t lane, std::uint32_t triangle, const std::string& why) {
    auto named = block().triangles();
    named[lane] = triangle;
    damage([&](LeafBlock& b) { b.set_names(named, b.lane_count(), 0); }, why);
  };
  const std::uint32_t count = mesh_.view().triangle_count();
  name(0, count, "holds triangle " + std::to_string(count) + " of " + std::to_string(count));
  name(1, block().triangle(0), "which another leaf holds too");
  ASSERT_TRUE(good.has_numbers());
  damage([](LeafBlock& b) { b.vertices(1)[b.vertex(2, 0)] += 1; }, "corner 2 of triangle ");
  damage([](LeafBlock& b) { b.set_vertex_numbers(b.vertex_numbers() ^ 1); },
         "corner 0 of triangle ");
  ASSERT_EQ(good.capacity(), 6u);
  damage([](LeafBlock& b) { b.set_vertex_numbers(b.vertex_numbers() | 7); }, "is vertex 7 of 6");
  for (const float edge : {good.edge_max() / 2, std::numeric_limits<float>::quiet_NaN()})
    damage([&](LeafBlock& b) { b.set_edge_max(edge); }, "edge_max is below an edge of triangle ");
  EXPECT_EQ(reason(), "sound");
}

TEST_F(DamagedTree, refuses_blocks_without_vertices_or_of_another_size) {
  use_terrain();
  const std::uint32_t capacity = block().capacity();
  block().set_capacity(0);
  expect("a block has no vertices");
  for (const std::uint32_t other : {8u, 12u}) {
    block().set_capacity(other);
    EXPECT_NE(reason(), "sound") << other;
  }
  block().set_capacity(capacity);
  EXPECT_EQ(reason(), "sound");
}

TEST_F(DamagedTree, refuses_an_arena_whose_last_cache_line_is_in_use) {
  // A block of 96 bytes in three cache lines: as it is made, and a cache line later.
  const TestMesh mesh(demo::soup(1).meshes[0]);
  const WideTree good = build_triangle_tree(mesh.view(), nullptr, TreeQuality::kFast);
  ASSERT_TRUE(ChildRef::is_leaf(good.root));
  ASSERT_EQ(good.arena.used(), 3 * kNodeAlign);
  tree_ = copy_of(good, good.arena.used());
  std::memcpy(tree_.arena.at(2), good.arena.at(0), 3 * Arena::kGranule);
  tree_.root = ChildRef::leaf(2, 1);
  const std::string why = sightline::reason(validate_triangle_tree(tree_, mesh.view(), nullptr));
  EXPECT_NE(why.find("the last cache line is in use"), std::string::npos) << why;
}

TEST_F(DamagedTree, refuses_a_triangle_that_is_gone) {
  use_terrain();
  LeafBlock& one = block();
  ASSERT_GE(one.lane_count(), 2u);
  ASSERT_TRUE(one.has_numbers());
  const std::uint32_t last = one.lane_count() - 1;
  auto named = one.triangles();
  const std::uint32_t lost = named[last];
  named[last] = named[0];
  one.set_names(named, last, 0);
  std::uint64_t numbers = one.vertex_numbers();
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t shift = 3 * (kLanes * c + last);
    numbers &= ~(std::uint64_t{7} << shift);
    numbers |= std::uint64_t{one.vertex(c, 0)} << shift;
  }
  one.set_vertex_numbers(numbers);
  expect("triangle " + std::to_string(lost) + " is in no leaf");
}

TEST_F(DamagedTree, refuses_facts_that_differ_from_the_content) {
  const auto damage = [&](auto& value, auto wrong, const std::string& why) {
    const auto good = value;
    value = wrong;
    expect(why);
    value = good;
  };
  damage(tree_.node_count, tree_.node_count + 1, "nodes and has");
  damage(tree_.block_count, tree_.block_count - 1, "blocks and has");
  damage(tree_.depth, tree_.depth - 1, "levels and has");
  damage(tree_.scale_exponent, 3, "the tree's units are 2^3");
  damage(tree_.bounds.max.x, tree_.bounds.max.x * 2, "bounds are not those of its content");
  damage(tree_.root, ChildRef::kEmpty, "granules are never reached");
  EXPECT_EQ(reason(), "sound");
}

TEST_F(DamagedTree, refuses_every_length_but_its_own) {
  for (std::size_t bytes = 0; bytes < tree_.arena.used(); bytes += Arena::kGranule) {
    const WideTree shorter = copy_of(tree_, bytes);
    ASSERT_FALSE(validate_triangle_tree(shorter, mesh_.view(), nullptr)) << bytes;
  }
  const WideTree longer = copy_of(tree_, tree_.arena.used() + 64);
  EXPECT_NE(sightline::reason(validate_triangle_tree(longer, mesh_.view(), nullptr))
                .find("2 granules are never reached"),
            std::string::npos);
}

TEST_F(DamagedTree, survives_any_bytes) {
  const std::uint64_t seed = 4;
  RecordProperty("seed", static_cast<int>(seed));
  std::mt19937_64 random(seed);
  const std::size_t words = tree_.arena.used() / 4;
  const WideTree good = copy_of(tree_, tree_.arena.used());
  for (int round = 0; round < 3000; ++round) {
    tree_ = copy_of(good, good.arena.used());
    auto* word = reinterpret_cast<std::uint32_t*>(tree_.arena.at(0));
    for (std::uint64_t hits = 1 + random() % 3; hits > 0; --hits) {
      // Half of the damage goes into the root node, which every walk reads.
      std::uint32_t& target = word[random() % (random() % 2 == 0 ? words : sizeof(WideNode) / 4)];
      const std::uint32_t other = word[random() % words];
      switch (random() % 3) {
        case 0:
          target ^= 1u << random() % 32;
          break;
        case 1:
          target = static_cast<std::uint32_t>(random());
          break;
        default:
          target = other;
      }
    }
    (void)validate_triangle_tree(tree_, mesh_.view(), nullptr);
  }
}

TEST(Validate, refuses_a_tree_deeper_than_kernels_walk) {
  // A chain: each node has one leaf of one triangle and the rest below.
  constexpr std::uint32_t kLevels = kMaxTreeDepth + 1;
  std::vector<Vec3f> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < 2 * kLevels; ++i) indices.insert(indices.end(), {0, 1, 2});
  const MeshView mesh{positions, indices};
  WideTree shallow =
      build_triangle_tree({positions, std::span(indices).first(3)}, nullptr, TreeQuality::kFast);
  WideTree tree;
  tree.bounds = shallow.bounds;
  const std::size_t block_bytes = shallow.blocks(shallow.root).front().granules() * Arena::kGranule;
  tree.arena = Arena(kLevels * (sizeof(WideNode) + 2 * block_bytes + kNodeAlign));
  tree.root = 0;
  for (std::uint32_t i = 0; i < kLevels; ++i) {
    const std::uint32_t granule = tree.arena.take(sizeof(WideNode));
    const std::uint32_t leaf = tree.arena.take(2 * block_bytes);
    WideNode& node = *reinterpret_cast<WideNode*>(tree.arena.at(granule));
    for (std::size_t child = 0; child < kArity; ++child) {
      const bool used = child == 0 || (child == 1 && i + 1 < kLevels);
      for (int k = 0; k < 3; ++k) {
        node.lower[k][child] = used ? -1 : std::numeric_limits<float>::infinity();
        node.upper[k][child] = used ? 1 : -std::numeric_limits<float>::infinity();
      }
      node.child[child] =
          !used        ? ChildRef::kEmpty
          : child == 0 ? ChildRef::leaf(leaf, 2)
                       : leaf + static_cast<std::uint32_t>(2 * block_bytes / Arena::kGranule);
    }
    for (std::uint32_t& order : node.order) order = 076543210;
    auto* block = reinterpret_cast<LeafBlock*>(tree.arena.at(leaf));
    for (std::uint32_t k : {2 * i, 2 * i + 1}) {
      std::memcpy(block, &shallow.blocks(shallow.root).front(), block_bytes);
      block->set_names({k, k, k, k}, 1, 0);
      block = block->next();
    }
  }
  tree.node_count = tree.depth = kLevels;
  tree.block_count = 2 * kLevels;
  EXPECT_NE(reason(validate_triangle_tree(tree, mesh, nullptr)).find("131 deep, at most 130"),
            std::string::npos)
      << reason(validate_triangle_tree(tree, mesh, nullptr));
}

TEST(Validate, accepts_what_the_builder_makes) {
  const Affine turned{{{0.6, -0.8, 0, 1e6}, {0.8, 0.6, 0, -7}, {0, 0, 3, 0.1}}};
  const Affine huge{{{1e300, 0, 0, 0}, {0, 1e-300, 0, 0}, {0, 0, 1e200, 0}}};
  for (const demo::DemoScene& scene : {demo::terrain(5000), demo::soup(700), demo::city(20'000),
                                       demo::town(), demo::six_triangles(), demo::soup(1)}) {
    for (const demo::DemoMesh& demo_mesh : scene.meshes) {
      TestMesh mesh(demo_mesh);
      // Some triangles that belong in no tree.
      mesh.indices.insert(mesh.indices.end(), {0, 0, 1});
      mesh.positions.push_back({std::numeric_limits<float>::infinity(), 0, 0});
      mesh.indices.insert(mesh.indices.end(),
                          {0, 1, static_cast<std::uint32_t>(mesh.positions.size() - 1)});
      for (const Affine* world : {static_cast<const Affine*>(nullptr), &turned, &huge}) {
        for (const TreeQuality quality : {TreeQuality::kFast, TreeQuality::kHigh}) {
          const WideTree tree = build_triangle_tree(mesh.view(), world, quality);
          EXPECT_EQ(reason(validate_triangle_tree(tree, mesh.view(), world)), "sound")
              << scene.name;
        }
      }
    }
  }
  const WideTree empty = build_triangle_tree({}, nullptr, TreeQuality::kFast);
  EXPECT_EQ(reason(validate_triangle_tree(empty, {}, nullptr)), "sound");
}

TEST(Validate, accepts_every_tree_of_several_parts_and_nothing_else) {
  std::vector<TestMesh> meshes;
  for (const demo::DemoScene& scene : {demo::soup(700), demo::town(), demo::six_triangles()}) {
    for (const demo::DemoMesh& mesh : scene.meshes) meshes.emplace_back(mesh);
  }
  // Parts that lie in one another, an empty one, and the last mesh three times.
  std::vector<Affine> places(meshes.size() + 3);
  std::vector<TreePart> parts;
  for (std::size_t i = 0; i < places.size(); ++i) {
    places[i].m[0][0] = 1 + 0.125 * static_cast<double>(i % 3);
    places[i].m[0][3] = 0.01 * static_cast<double>(i);
    const Affine* world = i % 2 == 0 ? &places[i] : nullptr;
    parts.push_back({meshes[std::min(i, meshes.size() - 1)].view(), world});
  }
  parts.insert(parts.begin() + 1, TreePart{});
  for (const TreeQuality quality : {TreeQuality::kFast, TreeQuality::kHigh}) {
    WideTree tree = build_triangle_tree(parts, quality);
    ASSERT_EQ(reason(validate_triangle_tree(tree, parts)), "sound");

    std::uint32_t leaf = tree.root;
    while (!ChildRef::is_leaf(leaf)) leaf = tree.node(leaf).child[0];
    auto& block = *reinterpret_cast<LeafBlock*>(tree.arena.at(ChildRef::granule(leaf)));
    const std::uint32_t own = block.placement();
    const auto place = [&](std::uint32_t placement) {
      block.set_names(block.triangles(), block.lane_count(), placement);
    };
    for (const std::uint32_t other : {1u, own == 0 ? 2u : 0u}) {
      place(other);
      EXPECT_NE(reason(validate_triangle_tree(tree, parts)), "sound");
    }
    place(static_cast<std::uint32_t>(parts.size()));
    EXPECT_NE(reason(validate_triangle_tree(tree, parts)).find("a block is of placement"),
              std::string::npos);
  }
}

TEST(Validate, judges_the_tree_over_placements) {
  const TestMesh mesh(demo::soup(50).meshes[0]);
  const MeshView view = mesh.view();
  std::vector<PlacementView> placements;
  std::vector<Box3d> placed;
  for (int i = 0; i < 300; ++i) {
    PlacementView& one = placements.emplace_back();
    one.world_from_mesh.m[0][3] = i % 17;
    one.world_from_mesh.m[1][3] = i % 19;
    one.world_from_mesh.m[2][3] = i % 23;
    Box3d& box = placed.emplace_back();
    for (const std::uint32_t index : mesh.indices)
      box.include(one.world_from_mesh.apply(mesh.positions[index]));
  }
  Result<SceneTree> scene =
      build_scene_tree({&view, 1}, placements, TreeQuality::kHigh, Joining::kNever);
  ASSERT_TRUE(scene.ok());
  const auto judge = [&] { return reason(validate_top_tree(scene->top, placed)); };
  EXPECT_EQ(judge(), "sound");

  placed[120].max.x += 1e-3;
  EXPECT_NE(judge().find("its box does not contain placement 120"), std::string::npos) << judge();
  placed[120].max.x -= 1e-3;
  placed.push_back(placed.back());
  EXPECT_NE(judge().find("placement 300 is in no leaf"), std::string::npos) << judge();
  placed.resize(200);
  EXPECT_NE(judge(), "sound");
}

}  // namespace
}  // namespace sightline
