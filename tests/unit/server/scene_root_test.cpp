// What a file below the scene root is when it cannot be opened.

#include "server/sources/scene_root.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace sightline {
namespace {

/// As many descriptors as are open now, and `more`.
class FewDescriptors {
 public:
  explicit FewDescriptors(int more) {
    ::getrlimit(RLIMIT_NOFILE, &before_);
    std::vector<int> taken;
    taken.reserve(static_cast<std::size_t>(more));
    for (int i = 0; i < more; ++i) taken.push_back(::dup(0));
    const int next = ::dup(0);
    ::close(next);
    for (const int number : taken) ::close(number);
    rlimit few = before_;
    few.rlim_cur = static_cast<rlim_t>(next);
    ::setrlimit(RLIMIT_NOFILE, &few);
  }
  ~FewDescriptors() { ::setrlimit(RLIMIT_NOFILE, &before_); }
  FewDescriptors(const FewDescriptors&) = delete;
  FewDescriptors& operator=(const FewDescriptors&) = delete;

 private:
  rlimit before_{};
};

class SceneRootFiles : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "sightline-root-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    std::ofstream(folder_ / "there") << "text";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

TEST_F(SceneRootFiles, are_not_missing_where_there_is_no_descriptor) {
  const auto root = SceneRoot::open(folder_);
  ASSERT_TRUE(root.ok());
  EXPECT_TRUE(root->open_file("there", 100).ok());
  for (const char* path : {"none", "there/none", "."}) {
    EXPECT_EQ(root->open_file(path, 100).error().code, "SOURCE_NOT_FOUND") << path;
  }
  EXPECT_EQ(root->open_file(std::string(300, 'x'), 100).error().code, "SOURCE_NOT_FOUND");
  const FewDescriptors few(0);
  EXPECT_EQ(root->open_file("there", 100).error().code, "STORE_BUSY");
  EXPECT_EQ(root->open_neighbour("there", "there", 100).error().code, "STORE_BUSY");
}

TEST_F(SceneRootFiles, say_why_their_root_cannot_be_opened) {
  const FewDescriptors few(1);
  const auto root = SceneRoot::open(folder_);
  ASSERT_FALSE(root.ok());
  EXPECT_EQ(root.error().code, "SCENE_ROOT_INVALID");
  EXPECT_EQ(root.error().message, "cannot open the scene root: Too many open files");
}

}  // namespace
}  // namespace sightline
