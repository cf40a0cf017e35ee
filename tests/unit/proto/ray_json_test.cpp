#include "proto/json/ray_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "core/base/infinity.h"
#include "core/query/attribute_name.h"

namespace sightline {
namespace {

RayQuery accepted(std::string body, const RayJsonRules& rules = {}) {
  auto query = decode_rays(body, rules);
  if (!query) {
    ADD_FAILURE() << body << "\n" << query.error().code << " " << query.error().message;
    return {};
  }
  return std::move(query).value();
}

struct Refusal {
  const char* body;
  const char* code;
  const char* pointer;
};

void expect_refusal(const Refusal& refusal, const RayJsonRules& rules = {}) {
  std::string body = refusal.body;
  const auto query = decode_rays(body, rules);
  ASSERT_FALSE(query.ok()) << refusal.body;
  EXPECT_EQ(query.error().code, refusal.code) << refusal.body << "\n" << query.error().message;
  EXPECT_EQ(query.error().pointer, refusal.pointer) << refusal.body;
  EXPECT_FALSE(query.error().message.empty());
}

TEST(RayJson, reads_rows_with_defaults) {
  const RayQuery query = accepted(R"({"rays":[{"origin":[1,2,3],"direction":[0,0,-1]},
                           {"tmax":7.5,"tmin":-2,"direction":[1e3,-4,5.25],"origin":[0,0,0]}]})");
  ASSERT_EQ(query.rays.size(), 2u);
  EXPECT_EQ(query.layout, AnswerLayout::kRows);
  EXPECT_EQ(query.fields, kDefaultHitFields);
  const Ray first = query.rays[0], second = query.rays[1];
  EXPECT_EQ(first.origin, (Vec3d{1, 2, 3}));
  EXPECT_EQ(first.direction, (Vec3d{0, 0, -1}));
  EXPECT_EQ(first.tmin, 0);
  EXPECT_EQ(first.tmax, kInf);
  EXPECT_EQ(second.direction, (Vec3d{1000, -4, 5.25}));
  EXPECT_EQ(second.tmin, -2);
  EXPECT_EQ(second.tmax, 7.5);
}

TEST(RayJson, reads_numbers_of_any_length_as_the_nearest_float64) {
  std::vector<std::string> numbers = {
      "0.1000000000000000055511151231257827021181583404541015625",  // what some programs print of
                                                                    // 0.1
      "-0.22222222222222222222222222222222201",
      "0.00000000000000000000000000000012345678901234567890123456789",
      "0.99999999999999999999999999999999999999999",
      "0.30000000000000000000000000000000000000000e-300",
      "0.00000000000000000001844674407370955161500000000000000001e+20",
      "123456789012345678901234567890.5", "1.00000000000000011102230246251565404236316680908203125",
      "1.00000000000000011102230246251565404236316680908203126"};
  // Every number of digits, with and without zeros behind the point, and an exponent.
  for (std::size_t digits = 1; digits < 60; ++digits) {
    for (const std::size_t zeros : {0u, 1u, 5u, 18u, 19u, 20u, 21u, 300u}) {
      std::string number = "0." + std::string(zeros, '0');
      for (std::size_t i = 0; i < digits; ++i) number += static_cast<char>('1' + (7 * i + 3) % 9);
      numbers.push_back(number);
      numbers.push_back("-" + number + "E-3");
      numbers.push_back(number + "e7");
    }
  }
  for (const std::string& number : numbers) {
    const RayQuery query =
        accepted(R"({"rays":[{"origin":[)" + number + R"(,0,0],"direction":[0,0,-1]}]})");
    ASSERT_EQ(query.rays.size(), 1u);
    EXPECT_EQ(query.rays[0].origin.x, std::strtod(number.c_str(), nullptr)) << number;
  }
}

TEST(RayJson, reads_flat_columns) {
  const RayQuery query = accepted(
      R"({"fields":["triangle","t"],"origins":[1,2,3,4,5,6],"tmax":[9,null],
          "directions":[0,0,1,0,1,0]})");
  ASSERT_EQ(query.rays.size(), 2u);
  EXPECT_EQ(query.layout, AnswerLayout::kColumns);
  EXPECT_EQ(query.fields, (FieldSet{HitField::kT, HitField::kTriangle}));
  EXPECT_EQ(query.rays[1].origin, (Vec3d{4, 5, 6}));
  EXPECT_EQ(query.rays[1].direction, (Vec3d{0, 1, 0}));
  EXPECT_EQ(query.rays[0].tmax, 9);
  EXPECT_EQ(query.rays[1].tmax, kInf);
  EXPECT_EQ(query.rays[1].tmin, 0);
}

TEST(RayJson, reads_no_rays_as_no_rays) {
  EXPECT_EQ(accepted(R"({"rays":[]})").rays.size(), 0u);
  EXPECT_EQ(accepted(R"({"origins":[],"directions":[]})").rays.size(), 0u);
}

TEST(RayJson, takes_null_as_no_upper_limit) {
  EXPECT_EQ(
      accepted(R"({"rays":[{"origin":[0,0,0],"direction":[1,0,0],"tmax":null}]})").rays.tmax[0],
      kInf);
}

TEST(RayJson, keeps_negative_zero_denormals_and_seventeen_digits) {
  const RayQuery query = accepted(
      R"({"rays":[{"origin":[-0.0,-0,5e-324],"direction":[0.1234567890123456789,2.2250738585072011e-308,
          1.7976931348623157e308],"tmin":-0e0}]})");
  const Ray ray = query.rays[0];
  EXPECT_TRUE(std::signbit(ray.origin.x));
  EXPECT_TRUE(std::signbit(ray.origin.y));
  EXPECT_EQ(ray.origin.z, 5e-324);
  EXPECT_EQ(ray.direction.x, 0.1234567890123456789);
  EXPECT_EQ(ray.direction.y, 2.2250738585072011e-308);
  EXPECT_EQ(ray.direction.z, std::numeric_limits<double>::max());
  EXPECT_TRUE(std::signbit(ray.tmin));
}

TEST(RayJson, rounds_once_to_the_nearest_float64) {
  // Halfway between 1 and its successor goes to even; one digit far behind tips it over.
  const RayQuery query = accepted(
      R"({"rays":[{"origin":[1.00000000000000011102230246251565404236316680908203125,
          1.000000000000000111022302462515654042363166809082031250000000000000000000000000000001,
          12345678901234567890123456789],"direction":[9007199254740993,1,1e-400]}]})");
  const Ray ray = query.rays[0];
  EXPECT_EQ(ray.origin.x, 1.0);
  EXPECT_EQ(ray.origin.y, std::nextafter(1.0, 2.0));
  EXPECT_EQ(ray.origin.z, 12345678901234567890123456789.0);
  EXPECT_EQ(ray.direction.x, 9007199254740992.0);
  EXPECT_EQ(ray.direction.z, 0.0);
}

TEST(RayJson, knows_a_key_that_is_written_with_escapes) {
  EXPECT_EQ(accepted(R"({"r\u0061ys":[{"\u006frigin":[1,2,3],"direction":[0,0,1]}]})").rays.size(),
            1u);
}

TEST(RayJson, names_the_place_of_each_fault_in_rows) {
  const std::string good = R"({"origin":[1,2,3],"direction":[0,0,1]})";
  const Refusal refusals[] = {
      {R"([])", "TYPE_WRONG", ""},
      {R"("rays")", "TYPE_WRONG", ""},
      {R"({})", "KEY_MISSING", ""},
      {R"({"fields":["t"]})", "KEY_MISSING", ""},
      {R"({"rays":{}})", "TYPE_WRONG", "/rays"},
      {R"({"rays":null})", "TYPE_WRONG", "/rays"},
      {R"({"rays":[7]})", "TYPE_WRONG", "/rays/0"},
      {R"({"rays":[[1,2,3]]})", "TYPE_WRONG", "/rays/0"},
      {R"({"rays":[{}]})", "KEY_MISSING", "/rays/0"},
      {R"({"rays":[{"origin":[1,2,3]}]})", "KEY_MISSING", "/rays/0"},
      {R"({"rays":[{"direction":[1,2,3]}]})", "KEY_MISSING", "/rays/0"},
      {R"({"rays":[],"raiz":1})", "KEY_UNKNOWN", "/raiz"},
      {R"({"rays":[],"a/b~c":1})", "KEY_UNKNOWN", "/a~1b~0c"},
      {R"({"rays":[],"rays":[]})", "KEY_DUPLICATE", "/rays"},
      {R"({"rays":[],"origins":[]})", "KEYS_MIXED", "/origins"},
      {R"({"tmin":[],"rays":[]})", "KEYS_MIXED", "/rays"},
      {R"({"rays":[{"origin":[1,2,3],"direction":[0,0,1],"tmix":1}]})", "KEY_UNKNOWN",
       "/rays/0/tmix"},
      {R"({"rays":[{"origin":[1,2,3],"direction":[0,0,1],"origin":[1,2,3]}]})", "KEY_DUPLICATE",
       "/rays/0/origin"},
      {R"({"rays":[{"origin":[1,2],"direction":[0,0,1]}]})", "LENGTH_WRONG", "/rays/0/origin"},
      {R"({"rays":[{"origin":[1,2,3,4],"direction":[0,0,1]}]})", "LENGTH_WRONG", "/rays/0/origin"},
      {R"({"rays":[{"origin":[],"direction":[0,0,1]}]})", "LENGTH_WRONG", "/rays/0/origin"},
      {R"({"rays":[{"origin":"1,2,3","direction":[0,0,1]}]})", "TYPE_WRONG", "/rays/0/origin"},
      {R"({"rays":[{"origin":[1,"2",3],"direction":[0,0,1]}]})", "TYPE_WRONG", "/rays/0/origin/1"},
      {R"({"rays":[{"origin":[1,null,3],"direction":[0,0,1]}]})", "TYPE_WRONG", "/rays/0/origin/1"},
      {R"({"rays":[{"origin":[1,[2],3],"direction":[0,0,1]}]})", "TYPE_WRONG", "/rays/0/origin/1"},
      {R"({"rays":[{"origin":[1,true,3],"direction":[0,0,1]}]})", "TYPE_WRONG", "/rays/0/origin/1"},
      {R"({"rays":[{"origin":[1,NaN,3],"direction":[0,0,1]}]})", "NUMBER_NOT_FINITE",
       "/rays/0/origin/1"},
      {R"({"rays":[{"origin":[1,2,3],"direction":[0,0,-Infinity]}]})", "NUMBER_NOT_FINITE",
       "/rays/0/direction/2"},
      {R"({"rays":[{"origin":[1,2,3],"direction":[0,0,1e309]}]})", "NUMBER_NOT_FINITE",
       "/rays/0/direction/2"},
      {R"({"rays":[{"origin":[1,2,3],"direction":[0,0,1],"tmax":Infinity}]})", "NUMBER_NOT_FINITE",
       "/rays/0/tmax"},
      {R"({"rays":[{"origin":[1,2,3],"direction":[0,0,1],"tmin":null}]})", "TYPE_WRONG",
       "/rays/0/tmin"},
      {R"({"rays":[{"origin":[1,2,3],"direction":[0,0,1],"tmax":"9"}]})", "TYPE_WRONG",
       "/rays/0/tmax"},
      {R"({"rays":[{"origin":[1,2,3],"direction":[0,0,0]}]})", "RAY_DIRECTION_ZERO",
       "/rays/0/direction"},
      {R"({"rays":[{"origin":[1,2,3],"direction":[0,-0.0,1e-400]}]})", "RAY_DIRECTION_ZERO",
       "/rays/0/direction"},
      {R"({"rays":[{"origin":[1,2,3],"direction":[0,0,1],"tmin":5,"tmax":4}]})",
       "RAY_LIMITS_REVERSED", "/rays/0/tmin"},
      {R"({"rays":[{"origin":[1,2,3],"direction":[0,0,1],"tmax":-4}]})", "RAY_LIMITS_REVERSED",
       "/rays/0/tmax"},
  };
  for (const Refusal& refusal : refusals) expect_refusal(refusal);

  std::string many = R"({"rays":[)";
  for (int i = 0; i < 17; ++i) many += good + ",";
  many += R"({"origin":[1,2,3],"direction":[0,0,0]}]})";
  expect_refusal({many.c_str(), "RAY_DIRECTION_ZERO", "/rays/17/direction"});
}

TEST(RayJson, names_the_place_of_each_fault_in_columns) {
  const Refusal refusals[] = {
      {R"({"origins":[1,2,3]})", "KEY_MISSING", ""},
      {R"({"tmin":[1]})", "KEY_MISSING", ""},
      {R"({"origins":[1,2],"directions":[1,2,3]})", "LENGTH_WRONG", "/origins"},
      {R"({"origins":[1,2,3],"directions":[1,2,3,4,5,6]})", "LENGTH_WRONG", "/directions"},
      {R"({"origins":[1,2,3],"directions":[1,2,3],"tmin":[]})", "LENGTH_WRONG", "/tmin"},
      {R"({"origins":[1,2,3],"directions":[1,2,3],"tmax":[1,2]})", "LENGTH_WRONG", "/tmax"},
      {R"({"origins":[1,2,3],"directions":[1,2,3],"tmax":1})", "TYPE_WRONG", "/tmax"},
      {R"({"origins":[1,2,3],"directions":[1,2,"3"]})", "TYPE_WRONG", "/directions/2"},
      {R"({"origins":[1,2,3,4,nan,6],"directions":[1,2,3,4,5,6]})", "NUMBER_NOT_FINITE",
       "/origins/4"},
      {R"({"origins":[1,2,3,4,5,6],"directions":[1,2,3,0,0,0]})", "RAY_DIRECTION_ZERO",
       "/directions/3"},
      {R"({"origins":[1,2,3],"directions":[1,2,3],"tmin":[2],"tmax":[1]})", "RAY_LIMITS_REVERSED",
       "/tmin/0"},
      {R"({"origins":[1,2,3],"directions":[1,2,3],"tmax":[-1]})", "RAY_LIMITS_REVERSED", "/tmax/0"},
      {R"({"origins":[[1,2,3]],"directions":[[1,2,3]]})", "TYPE_WRONG", "/origins/0"},
  };
  for (const Refusal& refusal : refusals) expect_refusal(refusal);
}

TEST(RayJson, refuses_what_is_not_json) {
  const Refusal refusals[] = {
      {"", "JSON_MALFORMED", ""},
      {"   ", "JSON_MALFORMED", ""},
      {"{", "JSON_MALFORMED", ""},
      {R"({"rays":[]}x)", "JSON_MALFORMED", ""},
      {R"({"rays":[]} {"rays":[]})", "JSON_MALFORMED", ""},
      {R"({"rays":[]}])", "JSON_MALFORMED", ""},
      {R"({"rays":[],})", "JSON_MALFORMED", ""},
      {R"({"rays":[{"origin":[1,2,3],"direction":[0,0,1]},]})", "JSON_MALFORMED", "/rays/1"},
      {R"({"rays":[{"origin":[1,2,3,],"direction":[0,0,1]}]})", "JSON_MALFORMED",
       "/rays/0/origin/3"},
      {R"({"rays":[{"origin":[1,2 3],"direction":[0,0,1]}]})", "JSON_MALFORMED", "/rays/0/origin"},
      {R"({"rays":[{"origin":[1,2,+3],"direction":[0,0,1]}]})", "JSON_MALFORMED",
       "/rays/0/origin/2"},
      {R"({"rays":[{"origin":[1,2,03],"direction":[0,0,1]}]})", "JSON_MALFORMED",
       "/rays/0/origin/2"},
      {R"({"rays":[{"origin":[1,2,.3],"direction":[0,0,1]}]})", "JSON_MALFORMED",
       "/rays/0/origin/2"},
      {R"({"rays":[{"origin":[1,2,3.],"direction":[0,0,1]}]})", "JSON_MALFORMED",
       "/rays/0/origin/2"},
      {R"({"rays":[{"origin":[1,2,0x3],"direction":[0,0,1]}]})", "JSON_MALFORMED",
       "/rays/0/origin/2"},
      {R"({"rays":[{"origin":[1,2,3f],"direction":[0,0,1]}]})", "JSON_MALFORMED",
       "/rays/0/origin/2"},
      {R"({"rays":[{"origin":[1,2,],"direction":[0,0,1]}]})", "JSON_MALFORMED", "/rays/0/origin/2"},
      {R"({"rays":[{"origin":[1,2,3},"direction":[0,0,1]}]})", "JSON_MALFORMED", "/rays/0/origin"},
      {R"({"rays":[{"origin" [1,2,3],"direction":[0,0,1]}]})", "JSON_MALFORMED", "/rays/0"},
      {R"({rays:[]})", "JSON_MALFORMED", ""},
      {"{\"rays\":[],\"\\ud800\":1}", "JSON_MALFORMED", ""},
      {"{\"r\xffys\":[]}", "JSON_MALFORMED", ""},
      {"\xef\xbb\xbf{\"rays\":[]}", "JSON_MALFORMED", ""},
  };
  for (const Refusal& refusal : refusals) {
    SCOPED_TRACE(refusal.body);
    expect_refusal(refusal);
    std::string body = refusal.body;
    EXPECT_EQ(decode_rays(body, {}).error().kind, ErrorKind::kMalformed);
  }
}

TEST(RayJson, lists_the_known_fields_when_one_is_unknown) {
  std::string body = R"({"rays":[],"fields":["t","paint"]})";
  const auto query = decode_rays(body, {});
  ASSERT_FALSE(query.ok());
  EXPECT_EQ(query.error().code, "FIELD_UNKNOWN");
  EXPECT_EQ(query.error().pointer, "/fields/1");
  for (const HitField field : all_hit_fields()) {
    EXPECT_NE(query.error().message.find(hit_field_name(field)), std::string::npos);
  }
  expect_refusal({R"({"rays":[],"fields":["t","t"]})", "FIELD_DUPLICATE", "/fields/1"});
  expect_refusal({R"({"rays":[],"fields":[]})", "FIELDS_EMPTY", "/fields"});
  expect_refusal({R"({"rays":[],"fields":"t"})", "TYPE_WRONG", "/fields"});
  expect_refusal({R"({"rays":[],"fields":[1]})", "TYPE_WRONG", "/fields/0"});
}

TEST(RayJson, takes_attributes_of_the_file_for_fields) {
  const RayQuery query = accepted(R"({"rays":[],"fields":["_B","t","_NAME","_a.b:c-9"]})");
  EXPECT_EQ(query.fields, (FieldSet{HitField::kT, HitField::kNamed}));
  EXPECT_EQ(query.named_fields, (std::vector<std::string>{"_B", "_NAME", "_a.b:c-9"}));
  expect_refusal({R"({"rays":[],"fields":["_B","_B"]})", "FIELD_DUPLICATE", "/fields/1"});
  for (const char* body : {R"({"rays":[],"fields":["_"]})", R"({"rays":[],"fields":["_a b"]})",
                           R"({"rays":[],"fields":["_\""]})", R"({"rays":[],"fields":["A_"]})"}) {
    expect_refusal({body, "FIELD_UNKNOWN", "/fields/0"});
  }
  EXPECT_TRUE(is_attribute_name("_" + std::string(63, 'x')));
  EXPECT_FALSE(is_attribute_name("_" + std::string(64, 'x')));
  std::string many = R"({"rays":[],"fields":["_0")";
  for (std::size_t i = 1; i <= kMostNamedFields; ++i) many += ",\"_" + std::to_string(i) + "\"";
  expect_refusal({(many + "]}").c_str(), "FIELDS_TOO_MANY", "/fields/16"});
}

TEST(RayJson, does_not_know_fields_where_there_are_none_to_choose) {
  expect_refusal({R"({"rays":[],"fields":["t"]})", "KEY_UNKNOWN", "/fields"},
                 {.max_rays = 10, .has_fields = false});
}

TEST(RayJson, stops_at_the_limit_of_rays) {
  const RayJsonRules two{.max_rays = 2, .has_fields = true};
  const std::string ray = R"({"origin":[1,2,3],"direction":[0,0,1]})";
  EXPECT_EQ(accepted("{\"rays\":[" + ray + "," + ray + "]}", two).rays.size(), 2u);
  const std::string rows = "{\"rays\":[" + ray + "," + ray + "," + ray + "]}";
  expect_refusal({rows.c_str(), "RAYS_TOO_MANY", "/rays/2"}, two);
  expect_refusal(
      {R"({"origins":[1,2,3,1,2,3,1,2,3],"directions":[]})", "RAYS_TOO_MANY", "/origins/6"}, two);
  expect_refusal({R"({"tmin":[1,2,3]})", "RAYS_TOO_MANY", "/tmin/2"}, two);
}

TEST(RayJson, keeps_a_hostile_key_short_in_its_answer) {
  std::string body = "{\"" + std::string(100000, 'k') + "\":1}";
  const auto query = decode_rays(body, {});
  ASSERT_FALSE(query.ok());
  EXPECT_LT(query.error().message.size(), 300u);
  EXPECT_LT(query.error().pointer.size(), 300u);
}

TEST(RayJson, reads_limits_as_distances_when_told_to_normalize) {
  const RayQuery query = accepted(
      R"({"normalize":true,"rays":[{"origin":[0,0,0],"direction":[3,0,4],"tmin":5,"tmax":10}]})");
  EXPECT_TRUE(query.normalize);
  EXPECT_EQ(query.rays[0].direction, (Vec3d{3, 0, 4})) << "the ray stays as it was sent";
  EXPECT_EQ(query.rays.tmin[0], 1);
  EXPECT_EQ(query.rays.tmax[0], 2);
  EXPECT_FALSE(accepted(R"({"rays":[]})").normalize);
  expect_refusal({R"({"rays":[],"normalize":1})", "TYPE_WRONG", "/normalize"});
  expect_refusal({R"({"rays":[],"normalize":true})", "KEY_UNKNOWN", "/normalize"},
                 {.has_scene = false});
}

const RayJsonRules kListRules{
    .max_rays = 10, .has_crossings = true, .has_max_hits = true, .max_hits = 5000};

TEST(RayJson, reads_how_hits_are_listed) {
  const RayQuery plain = accepted(R"({"rays":[]})", kListRules);
  EXPECT_EQ(plain.crossings, Crossings::kEvery);
  EXPECT_EQ(plain.max_hits, 1000u);
  const RayQuery rows =
      accepted(R"({"max_hits":0,"crossings":"once","rays":[],"fields":["t"]})", kListRules);
  EXPECT_EQ(rows.crossings, Crossings::kOnce);
  EXPECT_EQ(rows.max_hits, 0u);
  EXPECT_EQ(rows.fields, (FieldSet{HitField::kT}));
  const RayQuery columns =
      accepted(R"({"origins":[],"crossings":"every","directions":[],"max_hits":5000})", kListRules);
  EXPECT_EQ(columns.crossings, Crossings::kEvery);
  EXPECT_EQ(columns.max_hits, 5000u);
  EXPECT_EQ(columns.layout, AnswerLayout::kColumns);
}

TEST(RayJson, refuses_any_other_way_of_listing_hits) {
  for (const Refusal& refusal : {
           Refusal{R"({"rays":[],"max_hits":-1})", "NUMBER_OUT_OF_RANGE", "/max_hits"},
           Refusal{R"({"rays":[],"max_hits":5001})", "NUMBER_OUT_OF_RANGE", "/max_hits"},
           Refusal{R"({"rays":[],"max_hits":1.5})", "NUMBER_OUT_OF_RANGE", "/max_hits"},
           Refusal{R"({"rays":[],"max_hits":1e3})", "NUMBER_OUT_OF_RANGE", "/max_hits"},
           Refusal{R"({"rays":[],"max_hits":99999999999999999999})", "NUMBER_OUT_OF_RANGE",
                   "/max_hits"},
           Refusal{R"({"rays":[],"max_hits":"7"})", "TYPE_WRONG", "/max_hits"},
           Refusal{R"({"rays":[],"max_hits":null})", "TYPE_WRONG", "/max_hits"},
           Refusal{R"({"rays":[],"max_hits":[7]})", "TYPE_WRONG", "/max_hits"},
           Refusal{R"({"rays":[],"max_hits":NaN})", "NUMBER_NOT_FINITE", "/max_hits"},
           Refusal{R"({"rays":[],"max_hits":1,"max_hits":1})", "KEY_DUPLICATE", "/max_hits"},
           Refusal{R"({"rays":[],"crossings":"twice"})", "VALUE_UNKNOWN", "/crossings"},
           Refusal{R"({"rays":[],"crossings":""})", "VALUE_UNKNOWN", "/crossings"},
           Refusal{R"({"rays":[],"crossings":1})", "TYPE_WRONG", "/crossings"},
           Refusal{R"({"rays":[],"crossings":true})", "TYPE_WRONG", "/crossings"},
           Refusal{R"({"rays":[],"crossings":once})", "JSON_MALFORMED", "/crossings"},
       }) {
    expect_refusal(refusal, kListRules);
  }
}

TEST(RayJson, knows_max_hits_and_crossings_only_where_they_mean_something) {
  expect_refusal({R"({"rays":[],"max_hits":1})", "KEY_UNKNOWN", "/max_hits"});
  expect_refusal({R"({"rays":[],"crossings":"once"})", "KEY_UNKNOWN", "/crossings"});
  const RayJsonRules count{.has_fields = false, .has_crossings = true};
  EXPECT_EQ(accepted(R"({"rays":[],"crossings":"once"})", count).crossings, Crossings::kOnce);
  expect_refusal({R"({"rays":[],"max_hits":1})", "KEY_UNKNOWN", "/max_hits"}, count);
  expect_refusal({R"({"rays":[],"fields":["t"]})", "KEY_UNKNOWN", "/fields"}, count);
}

}  // namespace
}  // namespace sightline
