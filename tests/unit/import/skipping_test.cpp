#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "tests/support/png.h"
#include "tests/unit/import/tiny_gltf_file.h"

// What an import does not need it does not read: shown once by pages of memory that end the process
// when they are touched, and once by the pages of the file that the system had to fetch.

namespace sightline {
namespace {

using test::json;
using test::TinyFile;

struct Range {
  std::size_t begin = 0, end = 0;
};

/// A textured file as modelling programs write it: one mesh with every usual attribute, four
/// images of 2048 * 2048, an animation, a mesh that no node shows and one that only another scene
/// shows.
class TexturedFile {
 public:
  TexturedFile() {
    file_.root["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1}}}};
    add_mesh(401, "terrain");
    add_image(1);
    add_image(2);
    file_.root["nodes"] = {{{"name", "ground"}, {"mesh", 0}}, {{"name", "elsewhere"}, {"mesh", 2}}};
    is_needed_ = false;
    add_animation();
    add_mesh(200, "shown by nobody");
    add_image(3);
    add_mesh(150, "of the other scene");
    add_image(4);
    bytes_ = file_.bytes();
    binary_begin_ = bytes_.size() - file_.binary.size();
  }

  const std::vector<std::byte>& bytes() const { return bytes_; }
  std::uint64_t geometry_bytes() const { return geometry_bytes_; }
  std::uint64_t json_bytes() const { return binary_begin_ - 28; }
  /// What no ray needs, as ranges of the file that are whole pages when it begins at one.
  std::vector<Range> skipped_pages(std::size_t page) const {
    std::vector<Range> out;
    for (const Range& range : skipped_) {
      const std::size_t begin = (binary_begin_ + range.begin + page - 1) / page * page;
      const std::size_t end = (binary_begin_ + range.end) / page * page;
      if (begin < end) out.push_back({begin, end});
    }
    return out;
  }

 private:
  void note(std::size_t begin, bool is_skipped) {
    if (is_skipped) {
      skipped_.push_back({begin, file_.binary.size()});
    } else {
      geometry_bytes_ += file_.binary.size() - begin;
    }
  }
  int add_floats(const std::vector<float>& numbers, const char* type, std::size_t count,
                 bool is_skipped) {
    const std::size_t begin = file_.binary.size();
    const int accessor = file_.add(numbers, 5126, type, count);
    note(begin, is_skipped);
    return accessor;
  }

  void add_mesh(std::uint32_t side, const char* name) {
    const std::size_t count = std::size_t{side} * side;
    std::vector<float> positions, normals(count * 3, 0.5f), tangents(count * 4, 1.0f),
        coordinates(count * 2, 0.25f);
    std::vector<std::uint32_t> indices;
    for (std::uint32_t y = 0; y < side; ++y) {
      for (std::uint32_t x = 0; x < side; ++x) {
        const float height = static_cast<float>((x * 7 + y * 13) % 31) / 8;
        positions.insert(positions.end(), {static_cast<float>(x), height, static_cast<float>(y)});
        if (x + 1 == side || y + 1 == side) continue;
        const std::uint32_t at = y * side + x;
        indices.insert(indices.end(), {at, at + side, at + 1, at + 1, at + side, at + side + 1});
      }
    }
    const int coordinate = add_floats(coordinates, "VEC2", count, true);
    const int position = add_floats(positions, "VEC3", count, !is_needed_);
    const int normal = add_floats(normals, "VEC3", count, true);
    const std::size_t begin = file_.binary.size();
    const int index = file_.add(indices, 5125, "SCALAR", indices.size());
    note(begin, !is_needed_);
    const int tangent = add_floats(tangents, "VEC4", count, true);
    const json attributes = {{"POSITION", position},
                             {"NORMAL", normal},
                             {"TANGENT", tangent},
                             {"TEXCOORD_0", coordinate}};
    file_.root["meshes"].push_back(
        {{"name", name}, {"primitives", {{{"attributes", attributes}, {"indices", index}}}}});
  }
  void add_image(std::uint32_t seed) {
    const std::size_t begin = file_.binary.size();
    file_.root["images"].push_back(
        {{"mimeType", "image/png"},
         {"bufferView", file_.add_view(test::noise_png(2048, 2048, seed))}});
    note(begin, true);
  }
  void add_animation() {
    const int times = add_floats(std::vector<float>(5000, 1), "SCALAR", 5000, true);
    const int values = add_floats(std::vector<float>(15000, 2), "VEC3", 5000, true);
    file_.root["animations"] = {
        {{"samplers", {{{"input", times}, {"output", values}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}}}}}};
  }

  TinyFile file_;
  std::vector<std::byte> bytes_;
  std::size_t binary_begin_ = 0;
  std::uint64_t geometry_bytes_ = 0;  ///< positions and indices of the scene's mesh
  std::vector<Range> skipped_;        ///< in the BIN chunk
  bool is_needed_ = true;
};

const TexturedFile& textured() {
  static const TexturedFile file;
  return file;
}

std::size_t page_size() { return static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)); }

void expect_same(const SceneDescription& a, const SceneDescription& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.warnings, b.warnings);
  EXPECT_EQ(a.nodes.size(), b.nodes.size());
  EXPECT_EQ(a.materials.size(), b.materials.size());
  ASSERT_EQ(a.instances.size(), b.instances.size());
  for (std::size_t i = 0; i < a.instances.size(); ++i) {
    EXPECT_EQ(a.instances[i].mesh, b.instances[i].mesh);
    EXPECT_EQ(a.instances[i].node, b.instances[i].node);
    EXPECT_EQ(a.instances[i].world_from_mesh, b.instances[i].world_from_mesh);
  }
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (std::size_t i = 0; i < a.meshes.size(); ++i) {
    EXPECT_EQ(a.meshes[i]->positions, b.meshes[i]->positions);
    EXPECT_EQ(a.meshes[i]->indices, b.meshes[i]->indices);
  }
}

void expect_little_touched(const ImportCounts& counts) {
  const std::uint64_t geometry = textured().geometry_bytes();
  EXPECT_EQ(counts.touched.positions + counts.touched.indices, geometry);
  EXPECT_EQ(counts.touched.json, textured().json_bytes());
  EXPECT_EQ(counts.touched.others, 0u);
  EXPECT_EQ(counts.bytes_touched, counts.touched.total());
  EXPECT_LT(counts.bytes_touched - counts.touched.json, geometry * 12 / 10);
  EXPECT_EQ(counts.skipped.images, 4u);
  EXPECT_EQ(counts.skipped.animations, 1u);
  EXPECT_EQ(counts.skipped.attributes, 9u);
  EXPECT_EQ(counts.skipped.meshes, 2u);
  EXPECT_EQ(counts.skipped.nodes, 1u);
  EXPECT_EQ(counts.skipped.scenes, 1u);
}

TEST(TexturedFile, is_loaded_although_nobody_may_touch_what_no_ray_needs) {
  const std::vector<std::byte>& bytes = textured().bytes();
  void* const memory =
      ::mmap(nullptr, bytes.size(), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  auto* const begin = static_cast<std::byte*>(memory);
  std::copy(bytes.begin(), bytes.end(), begin);
  std::size_t forbidden = 0;
  for (const Range& range : textured().skipped_pages(page_size())) {
    ASSERT_EQ(::mprotect(begin + range.begin, range.end - range.begin, PROT_NONE), 0);
    forbidden += range.end - range.begin;
  }
  EXPECT_GT(forbidden, bytes.size() / 2);
  for (const bool is_kept : {false, true}) {
    ImportOptions options;
    // Then hits may ask for normals, which the import does not touch for that.
    if (is_kept) options.owner = std::shared_ptr<const void>(begin, [](const void*) {});
    const auto scene = import_bytes({begin, bytes.size()}, options);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    expect_little_touched(scene->counts);
    EXPECT_EQ(scene->meshes[0]->triangle_count(), 320000u);
    EXPECT_EQ(scene->meshes[0]->attributes.size(), is_kept ? 1u : 0u);
  }
  ::munmap(memory, bytes.size());
}

/// The file on a disk, not in memory.
class ColdFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("sightline-skipping-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    path_ = folder_ / "textured.glb";
    const auto& bytes = textured().bytes();
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CLOEXEC);
    ASSERT_GE(descriptor_, 0);
    ASSERT_EQ(::fsync(descriptor_), 0);
    make_cold();
    if (in_memory({0, bytes.size()}) > 0) {
      GTEST_SKIP() << "the file system of " << folder_ << " keeps what was written in memory";
    }
  }
  void TearDown() override {
    ::close(descriptor_);
    std::filesystem::remove_all(folder_);
  }

  void make_cold() { ::posix_fadvise(descriptor_, 0, 0, POSIX_FADV_DONTNEED); }

  /// Bytes of the file's pages in this range that the system holds in memory.
  std::size_t in_memory(const Range& range) const {
    const std::size_t page = page_size(), size = textured().bytes().size();
    void* const mapped = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, descriptor_, 0);
    EXPECT_NE(mapped, MAP_FAILED);
    std::vector<unsigned char> pages((size + page - 1) / page);
    EXPECT_EQ(::mincore(mapped, size, pages.data()), 0);
    ::munmap(mapped, size);
    std::size_t count = 0;
    for (std::size_t i = range.begin / page; i < (range.end + page - 1) / page; ++i) {
      count += pages[i] & 1u;
    }
    return count * page;
  }

  std::filesystem::path folder_, path_;
  int descriptor_ = -1;
};

TEST_F(ColdFile, is_fetched_from_the_disk_only_where_a_ray_needs_it) {
  const std::uint64_t geometry = textured().geometry_bytes();
  std::uint64_t fetched = 0, touched = 0;
  // A system that is short of memory may take back pages before they are counted.
  for (int attempt = 0; attempt < 5 && fetched < geometry; ++attempt) {
    make_cold();
    const auto scene = import_file(path_, {});
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    expect_little_touched(scene->counts);
    for (const Range& range : textured().skipped_pages(page_size())) {
      EXPECT_EQ(in_memory(range), 0u) << "bytes " << range.begin << " to " << range.end;
    }
    fetched = in_memory({0, textured().bytes().size()});
    touched = scene->counts.bytes_touched;
  }
  EXPECT_GE(fetched, geometry);
  EXPECT_LT(fetched, geometry * 12 / 10);
  std::printf("%zu bytes in the file, %llu of positions and indices, %llu fetched, %llu touched\n",
              textured().bytes().size(), static_cast<unsigned long long>(geometry),
              static_cast<unsigned long long>(fetched), static_cast<unsigned long long>(touched));
}

TEST_F(ColdFile, is_read_whole_by_the_twin_that_skips_nothing_and_gives_the_same_scene) {
  ImportOptions everything;
  everything.skip = false;
  const auto whole = import_file(path_, everything);
  ASSERT_TRUE(whole.ok()) << whole.error().message;
  const std::size_t size = textured().bytes().size();
  EXPECT_GE(in_memory({0, size}), size);
  EXPECT_EQ(whole->counts.bytes_touched, size);
  const auto scene = import_file(path_, {});
  ASSERT_TRUE(scene.ok());
  expect_same(*scene, *whole);
  EXPECT_EQ(scene->counts.degenerate_triangles, whole->counts.degenerate_triangles);
}

TEST(ImportWithoutSkips, does_not_mind_what_is_wrong_where_nobody_looks) {
  TinyFile file = test::one_triangle();
  file.root["meshes"].push_back(file.root["meshes"][0]);
  const int too_large = file.add<std::uint16_t>({0, 1, 99}, 5123, "SCALAR", 3);
  file.root["meshes"][1]["primitives"][0]["indices"] = too_large;
  file.root["images"] = {{{"uri", "../../etc/passwd"}}, {{"uri", "absent.png"}}, 7, {{"uri", 7}}};
  file.root["buffers"] = {{{"byteLength", file.binary.size()}},
                          {{"byteLength", 5}, {"uri", "absent.bin"}}};
  ImportOptions everything;
  everything.skip = false;
  const auto whole = file.import(everything), scene = file.import();
  ASSERT_TRUE(whole.ok()) << whole.error().message;
  ASSERT_TRUE(scene.ok());
  expect_same(*scene, *whole);
  EXPECT_EQ(scene->counts.skipped.images, 4u);
  EXPECT_EQ(scene->counts.skipped.meshes, 1u);
}

TEST(Triangles, without_area_are_counted_exactly) {
  TinyFile file = test::one_triangle();
  const float tiny = 0x1p-149f, huge = 0x1p127f, next = 1 + 0x1p-23f;
  const int positions = file.add_positions({
      0,     0,    0,    1,    1,    1,    2,    2,    2,     // on a line
      0,     0,    0,    tiny, 0,    0,    0,    tiny, 0,     // as small as can be
      -huge, 0,    0,    huge, 0,    0,    0,    tiny, 0,     // as thin as can be
      0,     0,    0,    1,    1,    1,    next, 1,    1,     // off the line by the last bit
      5,     5,    5,    5,    5,    5,    6,    7,    8,     // two corners at one place
      0.1f,  0.1f, 0.1f, 0.2f, 0.2f, 0.2f, 0.3f, 0.3f, 0.3f,  // on a line, as float32 has them
      0,     0,    0,    3,    1,    0,    6,    2,    0,     // on a line that is no diagonal
  });
  auto& primitive = file.root["meshes"][0]["primitives"][0];
  primitive["attributes"]["POSITION"] = positions;
  primitive.erase("indices");
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->meshes[0]->triangle_count(), 7u);
  EXPECT_EQ(scene->counts.degenerate_triangles, 4u);
  EXPECT_EQ(scene->counts.nonfinite_triangles, 0u);
}

TEST(Materials, keep_their_alpha_mode) {
  TinyFile file = test::one_triangle();
  file.root["materials"] = {json::object(),
                            {{"alphaMode", "MASK"}},
                            {{"alphaMode", "BLEND"}},
                            {{"alphaMode", "OPAQUE"}},
                            {{"alphaMode", "GLASS"}}};
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  std::string modes;
  for (const Material& material : scene->materials) {
    modes += std::string(alpha_mode_name(material.alpha_mode)) + " ";
  }
  EXPECT_EQ(modes, "OPAQUE MASK BLEND OPAQUE OPAQUE ");
  ASSERT_EQ(scene->warnings.size(), 1u);
  EXPECT_EQ(scene->warnings[0],
            "material 4: alphaMode \"GLASS\" is not known and was taken for OPAQUE");
  file.root["materials"] = {{{"alphaMode", 1}}};
  EXPECT_EQ(file.code(), "GLTF_VALUE_INVALID");
}

}  // namespace
}  // namespace sightline
