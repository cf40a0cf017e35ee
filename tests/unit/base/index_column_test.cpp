// Indices with a list and without one: the same to who reads them.

#include "core/base/index_column.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace sightline {
namespace {

using Three = std::array<std::uint32_t, 3>;

TEST(IndexColumn, reads_the_same_with_a_list_and_without) {
  const IndexColumn listed{0, 1, 2, 3, 4, 5};
  const IndexColumn sequence = IndexColumn::sequence(6);
  EXPECT_EQ(listed.listed().size(), 6u);
  EXPECT_TRUE(sequence.listed().empty());
  for (const IndexColumn* column : {&listed, &sequence}) {
    EXPECT_EQ(column->size(), 6u);
    EXPECT_FALSE(column->empty());
    EXPECT_EQ((*column)[4], 4u);
    EXPECT_EQ(column->corners(0), (Three{0, 1, 2}));
    EXPECT_EQ(column->corners(1), (Three{3, 4, 5}));
    EXPECT_EQ(std::vector<std::uint32_t>(column->begin(), column->end()),
              (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
    EXPECT_EQ(IndexView(*column).corners(1), (Three{3, 4, 5}));
  }
  EXPECT_EQ(listed, sequence);
  EXPECT_EQ(sequence, listed);
  EXPECT_FALSE(listed == IndexColumn::sequence(3));
  EXPECT_FALSE((IndexColumn{0, 1, 2, 3, 5, 4} == sequence));
  EXPECT_FALSE((IndexColumn{0, 2, 1} == IndexColumn{0, 1, 2}));
}

TEST(IndexColumn, forgets_only_a_list_that_counts_from_zero) {
  IndexColumn counts{0, 1, 2};
  counts.forget_sequence();
  EXPECT_TRUE(counts.listed().empty());
  EXPECT_EQ(counts.size(), 3u);
  for (IndexColumn other : {IndexColumn{1, 2, 3}, IndexColumn{0, 1, 1}, IndexColumn{0, 2, 1}}) {
    other.forget_sequence();
    EXPECT_EQ(other.listed().size(), 3u);
  }
  IndexColumn none;
  none.forget_sequence();
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none, IndexColumn::sequence(0));
}

TEST(IndexColumn, is_listed_again_to_be_written) {
  IndexColumn column = IndexColumn::sequence(3);
  column.own().push_back(7);
  EXPECT_EQ(column, (IndexColumn{0, 1, 2, 7}));
  EXPECT_EQ(column.listed().size(), 4u);
  const auto kept = std::make_shared<std::vector<std::uint32_t>>(std::vector<std::uint32_t>{4, 5});
  IndexColumn shared(SharedColumn<std::uint32_t>(*kept, kept));
  EXPECT_EQ(shared.listed().data(), kept->data());
  shared.own()[0] = 6;
  EXPECT_EQ(shared, (IndexColumn{6, 5}));
  EXPECT_EQ(kept->front(), 4u);
}

}  // namespace
}  // namespace sightline
