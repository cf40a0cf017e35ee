#include <draco/attributes/attribute_quantization_transform.h>
#include <draco/compression/decode.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include "tests/support/data_folder.h"
#include "tests/unit/import/displaced.h"
#include "tests/unit/import/tiny_gltf_file.h"

// The same content written in several ways: spot.glb plain, quantised, compressed by meshopt and by
// Draco; the city as nodes and as instances. What quantisation or float32 matrices move, and no
// more, may move the answers (displaced.h).

namespace sightline {
namespace {

using test::closest_of;
using test::compare_displaced;
using test::DisplacedSurface;
using test::json;
using test::rays_at;
using test::TinyFile;

constexpr std::size_t kRays = 100000;

std::shared_ptr<const Scene> load(const std::filesystem::path& file) {
  auto description = import_file(file, {});
  EXPECT_TRUE(description.ok()) << description.error().message;
  if (!description) return nullptr;
  auto scene = Scene::build(*std::move(description));
  EXPECT_TRUE(scene.ok());
  return scene ? *scene : nullptr;
}

struct RawFile {
  explicit RawFile(const std::filesystem::path& path) : bytes(test::read_bytes(path)) {
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + 12, 4);
    const char* text = reinterpret_cast<const char*>(bytes.data()) + 20;
    root = json::parse(text, text + length);
    binary = bytes.data() + 28 + length;
  }
  std::vector<std::byte> bytes;
  json root;
  const std::byte* binary = nullptr;
};

/// How far quantisation and the rounding of decoded positions to float32 may move one coordinate of
/// a file whose positions are normalised int16 under one node with a scale. The number of bits is
/// found in the numbers themselves: writers fill the lower bits by repeating the upper ones.
double step_of_integers(const Scene& scene, const RawFile& file) {
  const double scale = file.root["nodes"][0]["scale"][0].get<double>();
  const auto& mesh = *scene.description().meshes[0];
  const auto stored = [](float x) {
    return std::lround(std::fabs(static_cast<double>(x)) * 32767);
  };
  // Of magnitudes of `bits` bits in a field of 15.
  const auto repeated = [](long value, int bits) {
    return value << (15 - bits) | value >> (2 * bits - 15);
  };
  int bits = 8;
  for (;; ++bits) {
    const auto fits = [&](float x) {
      return repeated(stored(x) >> (15 - bits), bits) == stored(x);
    };
    if (bits == 15 ||
        std::all_of(mesh.positions.begin(), mesh.positions.end(),
                    [&](const Vec3f& p) { return fits(p.x) && fits(p.y) && fits(p.z); })) {
      break;
    }
  }
  const long steps = (1L << bits) - 1;
  double repeating = 0;  // what the repeated bits add to or take from k / steps
  for (long k = 0; k <= steps; ++k) {
    const auto exact = static_cast<double>(k) / static_cast<double>(steps);
    const auto kept = static_cast<double>(bits == 15 ? k : repeated(k, bits)) / 32767;
    repeating = std::max(repeating, std::fabs(kept - exact));
  }
  std::printf("%d bits with the sign, ", bits + 1);
  return scale * (0.5 / static_cast<double>(steps) + repeating + 0x1p-24);
}

/// The same for Draco, whose bytes state bits and range.
double step_of_draco(const RawFile& file) {
  const json& view = file.root["bufferViews"][0];
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(file.binary) + view.value("byteOffset", 0),
              view["byteLength"].get<std::size_t>());
  draco::Decoder decoder;
  decoder.SetSkipAttributeTransform(draco::GeometryAttribute::POSITION);
  auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
  draco::AttributeQuantizationTransform transform;
  if (!mesh.ok() || !transform.InitFromAttribute(
                        *mesh.value()->GetNamedAttribute(draco::GeometryAttribute::POSITION))) {
    ADD_FAILURE() << "the bytes state no quantisation";
    return 0;
  }
  std::printf("%d bits, ", transform.quantization_bits());
  const double range = static_cast<double>(transform.range());
  double largest = range;
  for (int axis = 0; axis < 3; ++axis) {
    largest = std::max(largest, std::fabs(static_cast<double>(transform.min_value(axis))) + range);
  }
  // Draco multiplies and adds in float32: three roundings.
  return range * 0.5 / ((1 << transform.quantization_bits()) - 1) + 3 * 0x1p-24 * largest;
}

using Corners = std::array<Vec3d, 3>;

Corners corners_of(const WorldTriangle& t) { return {t.v0, t.v1, t.v2}; }

/// Which triangle of `plain` each triangle of `other` was: the one whose corners are within `step`
/// of its corners on each axis, in the same order but for where it begins.
class Correspondence {
 public:
  Correspondence(const Scene& plain, const Scene& other, double step) : step_(step) {
    const auto count = static_cast<std::uint32_t>(plain.instanced_triangle_count());
    for (std::uint32_t i = 0; i < count; ++i) {
      const Corners corners = corners_of(plain.world_triangle({0, i}));
      for (const Vec3d& p : corners) by_x_.emplace(p.x, i);
    }
    for (std::uint32_t i = 0; i < other.instanced_triangle_count(); ++i) {
      origin_.push_back(find(plain, corners_of(other.world_triangle({0, i}))));
      if (origin_.back() == kNone || ++taken_[origin_.back()] > 1) ++unmatched_;
    }
  }
  std::size_t unmatched() const { return unmatched_; }
  TriangleId origin_of(TriangleId id) const { return {0, origin_[id.triangle]}; }
  double farthest() const { return farthest_; }

 private:
  std::uint32_t find(const Scene& plain, const Corners& moved) {
    const auto end = by_x_.upper_bound(moved[0].x + step_);
    for (auto at = by_x_.lower_bound(moved[0].x - step_); at != end; ++at) {
      if (taken_[at->second] > 0) continue;
      const Corners corners = corners_of(plain.world_triangle({0, at->second}));
      for (std::size_t turn = 0; turn < 3; ++turn) {
        double farthest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          for (int axis = 0; axis < 3; ++axis) {
            farthest =
                std::max(farthest, std::fabs(corners[(k + turn) % 3][axis] - moved[k][axis]));
          }
        }
        if (farthest > step_) continue;
        farthest_ = std::max(farthest_, farthest);
        return at->second;
      }
    }
    return kNone;
  }

  double step_;
  std::multimap<double, std::uint32_t> by_x_;
  std::vector<std::uint32_t> origin_;
  std::map<std::uint32_t, int> taken_;
  std::size_t unmatched_ = 0;
  double farthest_ = 0;
};

TEST(SpotVariants, agree_within_their_quantisation) {
  const auto data = test::data_folder();
  if (!data) GTEST_SKIP() << "no shared data folder (set SIGHTLINE_DATA)";
  const auto plain = load(*data / "scenes/spot.glb");
  ASSERT_NE(plain, nullptr);
  const RayBatch rays = rays_at(plain->bounds(), kRays, 20261121);
  const HitBatch wanted = closest_of(*plain, rays);
  for (const char* name : {"spot_quantized.glb", "spot_meshopt.glb", "spot_draco.glb"}) {
    SCOPED_TRACE(name);
    const RawFile file(*data / "scenes" / name);
    const auto scene = load(*data / "scenes" / name);
    ASSERT_NE(scene, nullptr);
    const double step = std::strcmp(name, "spot_draco.glb") == 0 ? step_of_draco(file)
                                                                 : step_of_integers(*scene, file);
    // Not only the answers: every triangle is there once, each coordinate moved by a step at most.
    ASSERT_EQ(scene->instanced_triangle_count(), plain->instanced_triangle_count());
    const Correspondence same(*plain, *scene, step);
    EXPECT_EQ(same.unmatched(), 0u);
    EXPECT_LE(same.farthest(), step);
    EXPECT_GT(same.farthest(), step / 2) << "the bound is no looser than it must be";
    const DisplacedSurface surface = {*plain, *scene,
                                      [&](TriangleId id) { return same.origin_of(id); },
                                      [&](TriangleId) { return std::sqrt(3.0) * step; }};
    std::string complaint;
    const auto tally =
        compare_displaced(surface, rays, wanted, closest_of(*scene, rays), complaint);
    std::printf("step %.3g, moved %.3g: %s\n", step, same.farthest(), tally.text().c_str());
    EXPECT_EQ(tally.unexplained, 0u) << complaint;
    EXPECT_GT(tally.hits, kRays / 10);
    EXPECT_GT(tally.same_triangle, tally.hits * 9 / 10);
  }
}

/// city_gpu_instancing.glb once more, each instance a node with the same translation, rotation and
/// scale: numbers of float32, which JSON holds exactly.
std::vector<std::byte> instances_as_nodes(const RawFile& file) {
  TinyFile nodes;
  nodes.root = file.root;
  nodes.root["nodes"] = json::array();
  nodes.root["scenes"] = {{{"nodes", json::array()}}};
  nodes.root["scene"] = 0;
  for (const char* key : {"extensionsUsed", "extensionsRequired"}) nodes.root.erase(key);
  const auto numbers = [&](const json& accessor_index, std::size_t n, std::size_t i) {
    const json& accessor = file.root["accessors"][accessor_index.get<std::size_t>()];
    const json& view = file.root["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    const std::size_t at = view.value("byteOffset", std::size_t{0}) +
                           accessor.value("byteOffset", std::size_t{0}) +
                           i * view.value("byteStride", n * 4);
    json out = json::array();
    for (std::size_t c = 0; c < n; ++c) {
      float value = 0;
      std::memcpy(&value, file.binary + at + c * 4, 4);
      out.push_back(static_cast<double>(value));
    }
    return out;
  };
  for (const json& node : file.root["nodes"]) {
    const json& attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    const std::size_t count =
        file.root["accessors"][attributes["TRANSLATION"].get<std::size_t>()]["count"];
    for (std::size_t i = 0; i < count; ++i) {
      nodes.root["scenes"][0]["nodes"].push_back(nodes.root["nodes"].size());
      nodes.root["nodes"].push_back({{"mesh", node["mesh"]},
                                     {"translation", numbers(attributes["TRANSLATION"], 3, i)},
                                     {"rotation", numbers(attributes["ROTATION"], 4, i)},
                                     {"scale", numbers(attributes["SCALE"], 3, i)}});
    }
  }
  nodes.binary.assign(file.binary, file.bytes.data() + file.bytes.size());
  return nodes.bytes();
}

TEST(CityVariants, give_the_same_bits_where_their_matrices_have_the_same_bits) {
  const auto data = test::data_folder();
  if (!data) GTEST_SKIP() << "no shared data folder (set SIGHTLINE_DATA)";
  const auto path = *data / "scenes/city_gpu_instancing.glb";
  const auto instanced = load(path);
  ASSERT_NE(instanced, nullptr);
  auto description = import_bytes(instances_as_nodes(RawFile(path)), {});
  ASSERT_TRUE(description.ok()) << description.error().message;
  const auto& ours = instanced->description().instances;
  ASSERT_EQ(description->instances.size(), ours.size());
  for (std::size_t i = 0; i < ours.size(); ++i) {
    ASSERT_EQ(description->instances[i].world_from_mesh, ours[i].world_from_mesh) << i;
    ASSERT_EQ(description->meshes[description->instances[i].mesh]->positions,
              instanced->description().meshes[ours[i].mesh]->positions);
  }
  const auto as_nodes = Scene::build(*std::move(description));
  ASSERT_TRUE(as_nodes.ok());
  const RayBatch rays = rays_at(instanced->bounds(), kRays, 7);
  const HitBatch a = closest_of(*instanced, rays), b = closest_of(**as_nodes, rays);
  EXPECT_EQ(a.t, b.t);
  EXPECT_EQ(a.instance, b.instance);
  EXPECT_EQ(a.triangle, b.triangle);
}

/// Which instance of `plain` each instance of `other` is: that of the same mesh that moves the
/// mesh's vertices least.
struct Pairing {
  std::vector<std::uint32_t> of_other;
  std::vector<double> moved;  ///< by instance of `plain`: the farthest of its mesh's vertices
  double most = 0;            ///< of all
  double most_of_bound = 0;   ///< over what rounding to float32 may move a vertex
  std::size_t equal_bits = 0;
};

/// Translation, rotation and scale rounded to float32 move a vertex on each axis by u |translation|
/// and, of the rest, u for the scale and 4 u for each product of a quaternion's numbers in three
/// columns: less than 8 u of its distance from the translation, with u = 2^-24.
double rounding_of_float32(const Affine& matrix, const Vec3d& world) {
  const double tx = matrix.m[0][3], ty = matrix.m[1][3], tz = matrix.m[2][3];
  return 0x1p-24 * std::sqrt(3.0) *
         (std::hypot(tx, ty, tz) + 8 * std::hypot(world.x - tx, world.y - ty, world.z - tz));
}

double farthest(const Mesh& mesh, const Affine& a, const Affine& b, Pairing& pairing) {
  double most = 0;
  for (const Vec3f& p : mesh.positions) {
    const Vec3d x = a.apply(p), y = b.apply(p);
    const double apart = std::hypot(x.x - y.x, x.y - y.y, x.z - y.z);
    most = std::max(most, apart);
    const double bound = rounding_of_float32(a, x);
    if (apart > 0) pairing.most_of_bound = std::max(pairing.most_of_bound, apart / bound);
  }
  pairing.most = std::max(pairing.most, most);
  return most;
}

Pairing pair_instances(const SceneDescription& plain, const SceneDescription& other) {
  Pairing pairing;
  pairing.moved.resize(plain.instances.size());
  std::vector<bool> taken(plain.instances.size(), false);
  for (const Instance& instance : other.instances) {
    const Mesh& mesh = *other.meshes[instance.mesh];
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < plain.instances.size(); ++i) {
      if (taken[i] || plain.meshes[plain.instances[i].mesh]->positions != mesh.positions) continue;
      double apart = 0;
      for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 4; ++c) {
          apart += std::fabs(plain.instances[i].world_from_mesh.m[r][c] -
                             instance.world_from_mesh.m[r][c]);
        }
      }
      if (apart < least) least = apart, best = i;
    }
    taken[best] = true;
    const Affine& matrix = plain.instances[best].world_from_mesh;
    pairing.of_other.push_back(static_cast<std::uint32_t>(best));
    pairing.moved[best] = farthest(mesh, matrix, instance.world_from_mesh, pairing);
    pairing.equal_bits += matrix == instance.world_from_mesh;
  }
  return pairing;
}

TEST(CityVariants, differ_only_by_what_float32_takes_from_the_matrices) {
  const auto data = test::data_folder();
  if (!data) GTEST_SKIP() << "no shared data folder (set SIGHTLINE_DATA)";
  const auto nodes = load(*data / "scenes/city_nodes.glb");
  const auto instanced = load(*data / "scenes/city_gpu_instancing.glb");
  ASSERT_NE(nodes, nullptr);
  ASSERT_NE(instanced, nullptr);
  const auto& a = nodes->description();
  const auto& b = instanced->description();
  ASSERT_EQ(a.instances.size(), b.instances.size());
  const Pairing pairing = pair_instances(a, b);
  EXPECT_LE(pairing.most_of_bound, 1.0);
  const RayBatch rays = rays_at(nodes->bounds(), kRays, 8);
  const HitBatch wanted = closest_of(*nodes, rays), got = closest_of(*instanced, rays);
  const DisplacedSurface surface = {*nodes, *instanced,
                                    [&](TriangleId id) {
                                      return TriangleId{pairing.of_other[id.instance], id.triangle};
                                    },
                                    [&](TriangleId id) { return pairing.moved[id.instance]; }};
  std::string complaint;
  const auto tally = compare_displaced(surface, rays, wanted, got, complaint);
  std::printf("%zu of %zu matrices have equal bits, vertices moved by %.3g at most; %s\n",
              pairing.equal_bits, a.instances.size(), pairing.most, tally.text().c_str());
  EXPECT_EQ(tally.unexplained, 0u) << complaint;
  EXPECT_GT(tally.hits, kRays / 2);
  // Where the matrix of the instance that is hit has the same bits, so has t.
  std::size_t equal = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!wanted.hit(i) || !got.hit(i)) continue;
    const TriangleId id = surface.origin_of(got.id(i));
    const auto& ours = a.instances[wanted.instance[i]].world_from_mesh;
    if (id != wanted.id(i) || ours != b.instances[got.instance[i]].world_from_mesh) continue;
    ++equal;
    EXPECT_EQ(wanted.t[i], got.t[i]);
  }
  EXPECT_GT(equal, 0u);
}

}  // namespace
}  // namespace sightline
