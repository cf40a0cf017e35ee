#include "proto/json/hit_json.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace sightline {
namespace {

/// One hit with a value in every field, then a miss.
struct Sample {
  HitBatch hits;
  std::vector<HitDetail> details;
  HitTerms terms;

  Sample() {
    hits.resize(2);
    hits.t = {5, std::numeric_limits<double>::infinity()};
    hits.instance = {3, kNone};
    hits.triangle = {40, kNone};
    details = {{{1, 2, -0.0}, {0, 0, 1}, 0.25, 0.5, true, true}, {}};
    terms.distance = {10, std::numeric_limits<double>::infinity()};
    terms.node_path = {"/town/roof", ""};
    terms.primitive = {1, kNone};
    terms.triangle = {12, kNone};
    terms.node = {7, kNone};
    terms.mesh = {8, kNone};
    terms.material = {9, kNone};
    terms.node_instance = {2, kNone};
    terms.node_name = {"roof \"east\"", ""};
    terms.mesh_name = {"house", ""};
    terms.material_name = {"tile", ""};
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    terms.attributes.shading_normal = {{0, 1, 0}, {kNan, kNan, kNan}};
    terms.attributes.uv = {{{0.5, -1}}, {{kNan, kNan}}};
    terms.attributes.uv1 = {{{2, 3}}, {{kNan, kNan}}};
    terms.attributes.tangent = {{{1, 0, 0, -1}}, {{kNan, kNan, kNan, kNan}}};
    terms.costs.nodes = {17, 4};
    terms.costs.blocks = {3, 0};
    terms.attributes.colour = {{{1, 0.5, 0, 1}}, {{kNan, kNan, kNan, kNan}}};
    terms.attributes.named = {{"_T", 1, {21, kNan}}, {"_W", 2, {0.5, -2, kNan, kNan}}};
  }
  std::string encode(FieldSet fields, AnswerLayout layout) const {
    return encode_hits(hits, details, terms, fields, layout);
  }
};

FieldSet every_field() {
  FieldSet all;
  for (const HitField field : all_hit_fields()) all.add(field);
  return all;
}

TEST(HitJson, writes_rows_with_null_for_a_miss) {
  EXPECT_EQ(Sample().encode({HitField::kT, HitField::kTriangle}, AnswerLayout::kRows),
            R"({"hits":[{"t":5,"triangle":12},null]})");
}

TEST(HitJson, writes_columns_with_null_or_minus_one_for_a_miss) {
  EXPECT_EQ(
      Sample().encode({HitField::kT, HitField::kTriangle, HitField::kPosition, HitField::kNode},
                      AnswerLayout::kColumns),
      R"({"t":[5,null],"triangle":[12,-1],"position":[1,2,-0.0,null,null,null],)"
      R"("node":["roof \"east\"",null]})");
}

TEST(HitJson, writes_every_field_in_its_order) {
  EXPECT_EQ(Sample().encode(every_field(), AnswerLayout::kRows),
            R"({"hits":[{"t":5,"distance":10,"instance":3,"primitive":1,"triangle":12,)"
            R"("position":[1,2,-0.0],"normal":[0,0,1],"shading_normal":[0,1,0],)"
            R"("barycentrics":[0.25,0.5],"uv":[0.5,-1],"uv1":[2,3],"tangent":[1,0,0,-1],)"
            R"("colour":[1,0.5,0,1],"front":true,)"
            R"("on_edge":true,"node":"roof \"east\"","node_id":7,"node_path":"/town/roof",)"
            R"("mesh":"house","mesh_id":8,"material":"tile","material_id":9,)"
            R"("node_instance":2,"cost_nodes":17,"cost_blocks":3,"_T":21,"_W":[0.5,-2]},null]})");
  const auto columns =
      nlohmann::json::parse(Sample().encode(every_field(), AnswerLayout::kColumns));
  EXPECT_EQ(columns.size(), kHitFieldCount + 1);  // two names for one field
  EXPECT_EQ(columns["_T"], nlohmann::json::parse("[21,null]"));
  EXPECT_EQ(columns["_W"], nlohmann::json::parse("[0.5,-2,null,null]"));
  EXPECT_EQ(columns["barycentrics"], nlohmann::json::parse("[0.25,0.5,null,null]"));
  EXPECT_EQ(columns["front"], nlohmann::json::parse("[true,null]"));
}

TEST(HitJson, has_the_floor_of_a_hit_by_default) {
  const auto hit =
      nlohmann::json::parse(Sample().encode(kDefaultHitFields, AnswerLayout::kRows))["hits"][0];
  for (const char* name : {"t", "position", "normal", "node", "mesh"}) {
    EXPECT_TRUE(hit.contains(name)) << name;
  }
}

TEST(HitJson, says_null_for_a_name_that_the_file_does_not_give) {
  Sample sample;
  sample.terms.mesh_name[0] = "";
  sample.terms.material[0] = kNone;
  EXPECT_EQ(sample.encode({HitField::kMesh, HitField::kMaterialId}, AnswerLayout::kRows),
            R"({"hits":[{"mesh":null,"material_id":null},null]})");
  EXPECT_EQ(sample.encode({HitField::kMesh, HitField::kMaterialId}, AnswerLayout::kColumns),
            R"({"mesh":[null,null],"material_id":[-1,-1]})");
}

TEST(HitJson, says_null_for_what_the_file_does_not_say_of_its_surface) {
  Sample sample;
  sample.terms.attributes.shading_normal[0] = sample.terms.attributes.shading_normal[1];
  sample.terms.attributes.uv[0] = sample.terms.attributes.uv[1];
  const FieldSet fields{HitField::kShadingNormal, HitField::kUv, HitField::kColour};
  EXPECT_EQ(sample.encode(fields, AnswerLayout::kRows),
            R"({"hits":[{"shading_normal":null,"uv":null,"colour":[1,0.5,0,1]},null]})");
  EXPECT_EQ(sample.encode(fields, AnswerLayout::kColumns),
            R"({"shading_normal":[null,null,null,null,null,null],"uv":[null,null,null,null],)"
            R"("colour":[1,0.5,0,1,null,null,null,null]})");
}

TEST(HitJson, says_the_distance_where_t_is_to_be_one) {
  Sample sample;
  sample.terms.t_is_distance = true;
  EXPECT_EQ(sample.encode({HitField::kT}, AnswerLayout::kColumns), R"({"t":[10,null]})");
}

TEST(HitJson, answers_no_rays_with_nothing) {
  EXPECT_EQ(encode_hits({}, {}, {}, kDefaultHitFields, AnswerLayout::kRows), R"({"hits":[]})");
  EXPECT_EQ(encode_hits({}, {}, {}, {HitField::kT}, AnswerLayout::kColumns), R"({"t":[]})");
  EXPECT_EQ(encode_occlusion({}), R"({"hits":[]})");
}

TEST(HitJson, writes_occlusion_as_booleans) {
  const std::uint8_t occluded[] = {1, 0, 1};
  EXPECT_EQ(encode_occlusion(occluded), R"({"hits":[true,false,true]})");
}

/// Two hits of a first ray that met three triangles, none of a second.
struct SampleLists {
  HitLists lists;
  std::vector<std::uint64_t> totals{3, 0};
  HitTerms terms;

  SampleLists() {
    lists.first = {0, 2, 2};
    lists.hits.t = {5, 6.5};
    lists.hits.instance = {3, 3};
    lists.hits.triangle = {40, 41};
    terms.triangle = {12, 13};
  }
  std::string encode(AnswerLayout layout) const {
    return encode_hit_lists(lists, totals, {}, terms, {HitField::kT, HitField::kTriangle}, layout);
  }
};

TEST(HitJson, writes_lists_as_rows_with_the_total_of_each_ray) {
  EXPECT_EQ(SampleLists().encode(AnswerLayout::kRows),
            R"({"results":[{"total":3,"hits":[{"t":5,"triangle":12},{"t":6.5,"triangle":13}]},)"
            R"({"total":0,"hits":[]}]})");
}

TEST(HitJson, writes_lists_as_columns_with_the_first_hit_of_each_ray) {
  EXPECT_EQ(SampleLists().encode(AnswerLayout::kColumns),
            R"({"totals":[3,0],"first":[0,2,2],"t":[5,6.5],"triangle":[12,13]})");
}

TEST(HitJson, writes_lists_of_no_rays) {
  HitLists none;
  none.first = {0};
  EXPECT_EQ(encode_hit_lists(none, {}, {}, {}, {HitField::kT}, AnswerLayout::kRows),
            R"({"results":[]})");
  EXPECT_EQ(encode_hit_lists(none, {}, {}, {}, {HitField::kT}, AnswerLayout::kColumns),
            R"({"totals":[],"first":[0],"t":[]})");
}

TEST(HitJson, writes_counts_of_any_size) {
  EXPECT_EQ(encode_counts({}), R"({"counts":[]})");
  const std::vector<std::uint64_t> counts{0, 7, 18446744073709551615u};
  EXPECT_EQ(encode_counts(counts), R"({"counts":[0,7,18446744073709551615]})");
}

}  // namespace
}  // namespace sightline
