#include "core/import/gltf/buffer_store.h"

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/unit/import/tiny_gltf_file.h"

namespace sightline::gltf {
namespace {

namespace fs = std::filesystem;

/// A folder of its own for each test, removed afterwards.
class BufferFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "sightline-buffers-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    root = pattern;
    scene = root / "scene";
    fs::create_directories(scene / "inner");
    write(scene / "near.bin", "0123456789");
    write(scene / "inner" / "deep.bin", "0123456789");
    write(root / "outside.bin", "0123456789");
    write(scene / "a.gltf", "{}");
  }
  void TearDown() override { fs::remove_all(root); }

  static void write(const fs::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
  }

  /// The code of the error, or the number of bytes.
  std::string open(const std::string& uri, std::uint64_t byte_length = 10) {
    const std::vector<BufferEntry> entries = {{byte_length, true, uri, false}};
    const ImportLimits limits;
    BufferStore store(entries, std::nullopt, scene / "a.gltf", limits);
    const auto bytes = store.bytes(0);
    return bytes ? std::to_string(bytes->size()) : bytes.error().code;
  }

  fs::path root, scene;
};

TEST_F(BufferFiles, are_found_beside_the_scene) {
  EXPECT_EQ(open("near.bin"), "10");
  EXPECT_EQ(open("inner/deep.bin"), "10");
  EXPECT_EQ(open("near.bin", 4), "4");
  EXPECT_EQ(open("near.bin", 11), "GLTF_BUFFER_INVALID");
  EXPECT_EQ(open("absent.bin"), "GLTF_FILE_UNREADABLE");
}

TEST_F(BufferFiles, are_not_reached_through_symbolic_links_that_leave_the_folder) {
  fs::create_symlink(root / "outside.bin", scene / "link.bin");
  fs::create_symlink("../outside.bin", scene / "relative.bin");
  fs::create_directory_symlink(root, scene / "up");
  fs::create_symlink("link.bin", scene / "twice.bin");
  for (const char* uri : {"link.bin", "relative.bin", "up/outside.bin", "twice.bin"}) {
    EXPECT_EQ(open(uri), "GLTF_URI_REFUSED") << uri;
  }
  fs::create_symlink("near.bin", scene / "inside.bin");
  EXPECT_EQ(open("inside.bin"), "10");
}

TEST_F(BufferFiles, are_not_taken_from_a_folder_whose_name_only_begins_alike) {
  fs::create_directories(root / "scene2");
  write(root / "scene2" / "x.bin", "0123456789");
  fs::create_symlink(root / "scene2" / "x.bin", scene / "x.bin");
  EXPECT_EQ(open("x.bin"), "GLTF_URI_REFUSED");
}

TEST_F(BufferFiles, are_regular_files_and_not_the_scene_itself) {
  EXPECT_EQ(open("inner"), "GLTF_FILE_UNREADABLE");
  EXPECT_EQ(open("a.gltf", 1), "GLTF_URI_REFUSED");
  fs::create_hard_link(scene / "a.gltf", scene / "twin.bin");
  EXPECT_EQ(open("twin.bin", 1), "GLTF_URI_REFUSED");
  ASSERT_EQ(::mkfifo((scene / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(open("pipe"), "GLTF_FILE_UNREADABLE");
}

TEST_F(BufferFiles, do_not_exist_for_a_scene_from_memory) {
  const std::vector<BufferEntry> entries = {{1, true, "near.bin", false}};
  const ImportLimits limits;
  BufferStore store(entries, std::nullopt, std::nullopt, limits);
  EXPECT_EQ(store.bytes(0).error().code, "GLTF_URI_REFUSED");
}

TEST_F(BufferFiles, are_bounded) {
  const std::vector<BufferEntry> entries = {{1, true, "near.bin", false}};
  ImportLimits limits;
  limits.file_bytes = 9;
  BufferStore store(entries, std::nullopt, scene / "a.gltf", limits);
  EXPECT_EQ(store.bytes(0).error().code, "GLTF_LIMIT_FILE_BYTES");
}

TEST(BufferStore, gives_the_binary_chunk_to_the_first_buffer_only) {
  const std::vector<std::byte> binary(8);
  const std::vector<BufferEntry> entries = {{6, false, "", false}, {6, false, "", false}};
  const ImportLimits limits;
  BufferStore store(entries, std::span<const std::byte>(binary), std::nullopt, limits);
  ASSERT_TRUE(store.bytes(0).ok());
  EXPECT_EQ(store.bytes(0)->size(), 6u);
  EXPECT_EQ(store.bytes(1).error().code, "GLTF_BUFFER_INVALID");
}

TEST(BufferStore, names_the_extension_that_could_fill_a_fallback_buffer) {
  const std::vector<BufferEntry> entries = {{6, false, "", true}};
  const ImportLimits limits;
  BufferStore store(entries, std::nullopt, std::nullopt, limits);
  const auto bytes = store.bytes(0);
  EXPECT_EQ(bytes.error().kind, ErrorKind::kUnsupported);
  EXPECT_NE(bytes.error().message.find("EXT_meshopt_compression"), std::string::npos);
}

}  // namespace
}  // namespace sightline::gltf
