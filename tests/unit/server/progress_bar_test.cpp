#include "server/operation/progress_bar.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(ProgressBar, draws_as_much_of_the_bar_as_is_done) {
  EXPECT_EQ(progress_line({"", std::nullopt}), "");
  EXPECT_EQ(progress_line({"building", std::nullopt}), "building ...");
  EXPECT_EQ(progress_line({"importing", 0}), "importing [" + std::string(32, '.') + "] 0%");
  EXPECT_EQ(progress_line({"importing", 50}),
            "importing [" + std::string(16, '#') + std::string(16, '.') + "] 50%");
  EXPECT_EQ(progress_line({"importing", 100}), "importing [" + std::string(32, '#') + "] 100%");
}

}  // namespace
}  // namespace sightline
