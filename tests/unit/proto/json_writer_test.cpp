#include "proto/json/json_writer.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

namespace sightline {
namespace {

std::string written(double value) {
  JsonWriter out(1);
  out.number(value);
  return out.take();
}

std::string written_text(std::string_view text) {
  JsonWriter out(1);
  out.string(text);
  return out.take();
}

TEST(JsonWriter, writes_the_shortest_number_that_reads_back) {
  EXPECT_EQ(written(5), "5");
  EXPECT_EQ(written(0.1), "0.1");
  EXPECT_EQ(written(-0.0), "-0.0");
  EXPECT_EQ(written(5e-324), "5e-324");
  EXPECT_EQ(written(1e22), "1e+22");
  EXPECT_EQ(written(-1.7976931348623157e308), "-1.7976931348623157e+308");
}

TEST(JsonWriter, writes_null_where_json_has_no_number) {
  EXPECT_EQ(written(std::numeric_limits<double>::infinity()), "null");
  EXPECT_EQ(written(-std::numeric_limits<double>::infinity()), "null");
  EXPECT_EQ(written(std::numeric_limits<double>::quiet_NaN()), "null");
}

TEST(JsonWriter, numbers_survive_the_way_out_and_back) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 20000; ++i) {
    const auto value = std::bit_cast<double>(random());
    const std::string text = written(value);
    if (text == "null") continue;
    EXPECT_EQ(std::bit_cast<std::uint64_t>(std::strtod(text.c_str(), nullptr)),
              std::bit_cast<std::uint64_t>(value));
    EXPECT_TRUE(nlohmann::json::accept(text)) << text;
  }
}

TEST(JsonWriter, escapes_names_and_repairs_bad_utf8) {
  EXPECT_EQ(written_text("house"), "\"house\"");
  EXPECT_EQ(written_text(""), "\"\"");
  EXPECT_EQ(written_text("a\"b\\c\n"), "\"a\\\"b\\\\c\\n\"");
  EXPECT_EQ(nlohmann::json::parse(written_text("Dach 屋根")).get<std::string>(), "Dach 屋根");
  EXPECT_TRUE(nlohmann::json::accept(written_text("\xff\xfe\x80 \x01")));
}

TEST(JsonWriter, grows_past_what_was_expected) {
  JsonWriter out(1);
  std::string expected;
  for (std::uint32_t i = 0; i < 5000; ++i) {
    out.number(i);
    out.raw(',');
    expected += std::to_string(i) + ",";
  }
  EXPECT_EQ(out.size(), expected.size());
  EXPECT_EQ(out.take(), expected);
}

}  // namespace
}  // namespace sightline
