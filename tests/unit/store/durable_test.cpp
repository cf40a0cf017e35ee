// What is on the disk before anybody is told so, and what is said when a disk does not take it; in
// a program of its own, because it replaces fsync.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <mutex>

#include "core/store/posix_file.h"
#include "tests/unit/store/text_scenes.h"

namespace {

std::mutex mutex;
std::vector<std::string> synced;  ///< in their order
std::string failing;              ///< the end of the paths that cannot be synced; empty: none

}  // namespace

extern "C" int fsync(int file) {
  std::array<char, 4096> path{};
  const std::string link = "/proc/self/fd/" + std::to_string(file);
  const ssize_t size = ::readlink(link.c_str(), path.data(), path.size());
  const std::lock_guard hold(mutex);
  synced.emplace_back(path.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  if (!failing.empty() && synced.back().ends_with(failing)) {
    errno = EIO;
    return -1;
  }
  return static_cast<int>(::syscall(SYS_fsync, file));
}

namespace sightline {
namespace {

void fail_at(const std::string& end) {
  const std::lock_guard hold(mutex);
  failing = end;
}

std::size_t count_synced(const std::filesystem::path& path) {
  const std::lock_guard hold(mutex);
  return static_cast<std::size_t>(std::count(synced.begin(), synced.end(), path.string()));
}

/// A scene that has one node, and the text as its name.
Result<std::shared_ptr<const Scene>> load_node(const LoadInput& input) {
  SceneDescription description;
  description.name =
      std::string(reinterpret_cast<const char*>(input.bytes.data()), input.bytes.size());
  description.nodes.push_back({description.name, 0});
  return Scene::build(std::move(description));
}

NodeChange hiding() {
  NodeChange change;
  change.hidden = true;
  return change;
}

TEST(Durable, a_new_folder_is_there_with_its_name) {
  const TemporaryFolder folder;
  const auto store = open_store(folder.path() / "new" / "data");
  ASSERT_NE(store, nullptr);
  EXPECT_GE(count_synced(folder.path()), 1u);
  EXPECT_GE(count_synced(folder.path() / "new"), 1u);
  // The format's name, and those of the folders below, of which nothing would be missed.
  EXPECT_GE(count_synced(folder.path() / "new" / "data"), 5u);
}

TEST(Durable, a_change_is_not_made_to_a_record_of_another_content) {
  const TemporaryFolder folder;
  {
    const auto opened = SceneStore::open({.folder = folder.path()}, load_node, {});
    SceneStore& store = **opened;
    ASSERT_TRUE(put_text(store, "a", "first").ok());
    ASSERT_TRUE(store.change("a", {{}, {hiding()}}).ok());
    fail_at("/scenes");
    EXPECT_FALSE(store.is_failing());
    EXPECT_EQ(put_text(store, "a", "second").error().code, "STORE_IO");
    fail_at("");
    EXPECT_TRUE(store.is_failing());
    EXPECT_EQ(text_of(store, "a"), "first");
    const auto changed = store.change("a", {{}, {hiding()}});
    ASSERT_FALSE(changed.ok());
    EXPECT_EQ(changed.error().code, "STORE_IO");
    EXPECT_NE(changed.error().message.find("send the file again"), std::string::npos);
    EXPECT_TRUE(store.is_failing());
    ASSERT_TRUE(put_text(store, "a", "third").ok());
    EXPECT_FALSE(store.is_failing());
    EXPECT_TRUE(store.change("a", {{}, {hiding()}}).ok());
    // A change that failed at its last step is of the same content.
    fail_at("/scenes");
    EXPECT_EQ(store.change("a", {{}, {hiding()}}).error().code, "STORE_IO");
    fail_at("");
    EXPECT_TRUE(store.change("a", {{}, {hiding()}}).ok());
  }
  EXPECT_EQ(text_of(*open_settled(folder.path()), "a"), "third");
}

TEST(Durable, a_small_file_is_read_whole_whatever_it_says_of_its_size) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "text";
  constexpr std::size_t kLimit = 10000;
  for (const std::size_t size : {0u, 1u, 4094u, 4095u, 4096u, 4097u, 9999u, 10000u}) {
    const std::string text(size, 'x');
    std::ofstream(file, std::ios::trunc) << text;
    EXPECT_EQ(*read_small_file(file, kLimit, "read it"), text) << size;
  }
  std::ofstream(file, std::ios::trunc) << std::string(kLimit + 1, 'x');
  EXPECT_EQ(read_small_file(file, kLimit, "read it").error().code, "STORE_DAMAGED");
  // These say 0.
  EXPECT_GT(read_small_file("/proc/self/maps", 16 << 20, "read it")->size(), 4096u);
}

}  // namespace
}  // namespace sightline
