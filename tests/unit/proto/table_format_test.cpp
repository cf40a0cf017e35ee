#include "proto/table_format.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(TableFormat, limits_an_archive_to_sizes_of_32_bits) {
  FieldSet all;
  std::uint64_t row = 0;
  for (const HitField field : all_hit_fields()) {
    all.add(field);
    row += 8 * hit_field_width(field);
  }
  EXPECT_GT(most_npz_rows(all, 1), 10'000'000u);
  EXPECT_LE(most_npz_rows(all, 1) * row, 0xffff0000u);
  EXPECT_LE(most_npz_rows({HitField::kPosition}) * 24, 0xffff0000u);
  EXPECT_GT(most_npz_rows({HitField::kT}), 400'000'000u);
  EXPECT_LE(most_npz_rows({HitField::kNamed}, 16) * 16 * 32, 0xffff0000u);
  EXPECT_LT(most_npz_rows(all, 3), most_npz_rows(all, 2));
}

}  // namespace
}  // namespace sightline
