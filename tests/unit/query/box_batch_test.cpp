#include "core/query/box_batch.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "core/base/infinity.h"

namespace sightline {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<Vec3d, 3> kAxes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// "1 min 2 BOX_REVERSED": box, part, component, code; "" for a good batch. Box 0 is always good.
template <class Box>
std::string fault(const Box& box) {
  BoxBatch boxes;
  boxes.push_back(Box3d{{0, 0, 0}, {1, 1, 1}});
  boxes.push_back(box);
  BoxFault found;
  if (check_boxes(boxes, found)) return "";
  return std::to_string(found.box) + " " + found.part + " " + std::to_string(found.component) +
         " " + found.code;
}

TEST(CheckBoxes, lets_flat_and_open_boxes_pass) {
  EXPECT_EQ(fault(Box3d{{0, 0, 0}, {0, 0, 0}}), "");
  EXPECT_EQ(fault(Box3d{{-kInf, 0, -kInf}, {0, kInf, kInf}}), "");
  EXPECT_EQ(fault(OrientedBox{{0, 0, 0}, {0, 0, kInf}, kAxes}), "");
  EXPECT_EQ(fault(OrientedBox{{0, 0, 0}, {1, 1, 1}, {{{2, 0, 0}, {1, 1, 0}, {0, 0, -3}}}}), "");
}

TEST(CheckBoxes, names_the_place_of_what_is_wrong) {
  EXPECT_EQ(fault(Box3d{{0, 0, 2}, {1, 1, 1}}), "1 min 2 BOX_REVERSED");
  EXPECT_EQ(fault(Box3d{{0, kNan, 0}, {1, 1, 1}}), "1 min 1 BOX_NOT_FINITE");
  EXPECT_EQ(fault(Box3d{{kInf, 0, 0}, {kInf, 1, 1}}), "1 min 0 BOX_NOT_FINITE");
  EXPECT_EQ(fault(Box3d{{-kInf, 0, 0}, {-kInf, 1, 1}}), "1 max 0 BOX_NOT_FINITE");
  EXPECT_EQ(fault(OrientedBox{{0, kInf, 0}, {1, 1, 1}, kAxes}), "1 center 1 BOX_NOT_FINITE");
  EXPECT_EQ(fault(OrientedBox{{0, 0, 0}, {1, -1, 1}, kAxes}), "1 half 1 BOX_HALF_NEGATIVE");
  EXPECT_EQ(fault(OrientedBox{{0, 0, 0}, {1, 1, kNan}, kAxes}), "1 half 2 BOX_NOT_FINITE");
  EXPECT_EQ(fault(OrientedBox{{0, 0, 0}, {1, 1, 1}, {{{1, 0, 0}, {0, 0, -0.0}, {0, 0, 1}}}}),
            "1 axes 1 BOX_AXIS_ZERO");
  EXPECT_EQ(fault(OrientedBox{{0, 0, 0}, {1, 1, 1}, {{{1, 0, 0}, {0, 1, 0}, {2, 3, 0}}}}),
            "1 axes -1 BOX_AXES_DEPENDENT");
}

TEST(CheckBoxes, takes_rotations_that_are_meant_as_such) {
  EXPECT_TRUE(is_rotation(0, 0, 0.70710678, 0.70710678));
  EXPECT_FALSE(is_rotation(0, 0, 1, 1));
  EXPECT_FALSE(is_rotation(0, 0, 0, 0));
  EXPECT_FALSE(is_rotation(kNan, 0, 0, 1));
}

}  // namespace
}  // namespace sightline
