#include "proto/json/box_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/base/infinity.h"
#include "proto/json/ray_box_json.h"

namespace sightline {
namespace {

/// "422 CODE /pointer" in short: the code and the pointer; "" for a body that is accepted.
std::string fault(std::string body, const BoxJsonRules& rules = {}) {
  const auto query = decode_boxes(body, rules);
  return query ? "" : query.error().code + " " + query.error().pointer;
}
std::string pair_fault(std::string body, const RayBoxJsonRules& rules = {}) {
  const auto query = decode_ray_boxes(body, rules);
  return query ? "" : query.error().code + " " + query.error().pointer;
}

TEST(BoxJson, reads_the_three_forms_of_boxes) {
  std::string body = R"({"boxes":[{"min":[-1,-0.0,-3],"max":[1,2,3]},
      {"half":[1,2,3],"center":[4,5,6],"rotation":[0,0,0,1]},
      {"center":[0,0,0],"half":[1,1,null],"axes":[[1,1,0],[1,-1,0],[0,0,2]]}],"of":"nodes","limit":7})";
  const auto query = decode_boxes(body, {});
  ASSERT_TRUE(query.ok()) << query.error().message;
  EXPECT_EQ(query->question.targets, BoxTargets::kNodes);
  EXPECT_EQ(query->limit, 7u);
  const BoxBatch& boxes = query->boxes;
  ASSERT_EQ(boxes.size(), 3u);
  EXPECT_EQ(boxes.aligned[0], (Box3d{{-1, 0, -3}, {1, 2, 3}}));
  EXPECT_TRUE(std::signbit(boxes.aligned[0].min.y));
  const OrientedBox& turned = boxes.oriented_boxes[boxes.oriented[1]];
  EXPECT_EQ(turned.center, (Vec3d{4, 5, 6}));
  EXPECT_EQ(turned.half, (Vec3d{1, 2, 3}));
  EXPECT_EQ(turned.axes[1], (Vec3d{0, 1, 0}));
  const OrientedBox& given = boxes.oriented_boxes[boxes.oriented[2]];
  EXPECT_EQ(given.axes[2], (Vec3d{0, 0, 2}));
  EXPECT_EQ(given.half.z, kInf);
}

TEST(BoxJson, takes_null_as_an_open_side) {
  std::string body = R"({"boxes":[{"min":[null,0,null],"max":[1,null,null]}]})";
  const auto query = decode_boxes(body, {});
  ASSERT_TRUE(query.ok());
  EXPECT_EQ(query->boxes.aligned[0], (Box3d{{-kInf, 0, -kInf}, {1, kInf, kInf}}));
  EXPECT_EQ(query->question.targets, BoxTargets::kTriangles);
  EXPECT_EQ(query->limit, 1000u);
}

TEST(BoxJson, names_the_place_of_what_is_wrong) {
  EXPECT_EQ(fault("{}"), "KEY_MISSING ");
  EXPECT_EQ(fault(R"({"boxes":1})"), "TYPE_WRONG /boxes");
  EXPECT_EQ(fault(R"({"boxes":[3]})"), "TYPE_WRONG /boxes/0");
  EXPECT_EQ(fault(R"({"boxes":[{}]})"), "KEY_MISSING /boxes/0");
  EXPECT_EQ(fault(R"({"boxes":[{"min":[0,0,0]}]})"), "KEY_MISSING /boxes/0");
  EXPECT_EQ(fault(R"({"boxes":[{"min":[0,0],"max":[1,1,1]}]})"), "LENGTH_WRONG /boxes/0/min");
  EXPECT_EQ(fault(R"({"boxes":[{"min":[0,0,0,0],"max":[1,1,1]}]})"), "LENGTH_WRONG /boxes/0/min");
  EXPECT_EQ(fault(R"({"boxes":[{"min":[0,"0",0],"max":[1,1,1]}]})"), "TYPE_WRONG /boxes/0/min/1");
  EXPECT_EQ(fault(R"({"boxes":[{"min":null,"max":[1,1,1]}]})"), "TYPE_WRONG /boxes/0/min");
  EXPECT_EQ(fault(R"({"boxes":[{"min":[0,NaN,0],"max":[1,1,1]}]})"),
            "NUMBER_NOT_FINITE /boxes/0/min/1");
  EXPECT_EQ(fault(R"({"boxes":[{"min":[0,0,0],"max":[1,1e999,1]}]})"),
            "NUMBER_NOT_FINITE /boxes/0/max/1");
  EXPECT_EQ(fault(R"({"boxes":[{"min":[0,0,0],"max":[1,1,1],"min":[0,0,0]}]})"),
            "KEY_DUPLICATE /boxes/0/min");
  EXPECT_EQ(fault(R"({"boxes":[{"min":[0,0,0],"max":[1,1,1],"centre":[0,0,0]}]})"),
            "KEY_UNKNOWN /boxes/0/centre");
  EXPECT_EQ(fault(R"({"boxes":[{"min":[0,0,0],"max":[1,1,1],"half":[0,0,0]}]})"),
            "KEYS_MIXED /boxes/0");
  EXPECT_EQ(fault(R"({"boxes":[{"min":[0,0,0],"max":[1,1,1]},{"min":[0,2,0],"max":[1,1,1]}]})"),
            "BOX_REVERSED /boxes/1/min/1");
  EXPECT_EQ(fault(R"({"boxes":[],"of":"meshes"})"), "VALUE_UNKNOWN /of");
  EXPECT_EQ(fault(R"({"boxes":[],"limit":-1})"), "NUMBER_OUT_OF_RANGE /limit");
  EXPECT_EQ(fault(R"({"boxes":[],"limit":1.5})"), "NUMBER_OUT_OF_RANGE /limit");
  EXPECT_EQ(fault(R"({"boxes":[],"limit":5})", {.has_limit = false}), "KEY_UNKNOWN /limit");
  EXPECT_EQ(fault(R"({"boxes":[{"min":[0,0,0],"max":[1,1,1]}]})", {.max_boxes = 0}),
            "BOXES_TOO_MANY /boxes/0");
  EXPECT_EQ(fault(R"({"boxes":[]} x)"), "JSON_MALFORMED ");
}

TEST(BoxJson, names_the_place_of_a_wrong_oriented_box) {
  const auto box = [](const std::string& half, const std::string& turn) {
    return R"({"boxes":[{"center":[0,0,0],"half":)" + half + "," + turn + "}]}";
  };
  EXPECT_EQ(fault(box("[1,1,1]", R"("rotation":[0,0,1,1])")),
            "BOX_ROTATION_NOT_UNIT /boxes/0/rotation");
  EXPECT_EQ(fault(box("[1,1,1]", R"("rotation":[0,0,1])")), "LENGTH_WRONG /boxes/0/rotation");
  EXPECT_EQ(fault(box("[1,-1,1]", R"("rotation":[0,0,0,1])")), "BOX_HALF_NEGATIVE /boxes/0/half/1");
  EXPECT_EQ(fault(box("[1,1,1]", R"("axes":[[1,0,0],[0,1,0]])")), "LENGTH_WRONG /boxes/0/axes");
  EXPECT_EQ(fault(box("[1,1,1]", R"("axes":[[1,0,0],[0,1,0],[0,0,0]])")),
            "BOX_AXIS_ZERO /boxes/0/axes/2");
  EXPECT_EQ(fault(box("[1,1,1]", R"("axes":[[1,0,0],[0,1,0],[1,1,0]])")),
            "BOX_AXES_DEPENDENT /boxes/0/axes");
  EXPECT_EQ(fault(box("[1,1,1]", R"("axes":[[1,0,0],[0,1,"x"],[1,1,0]])")),
            "TYPE_WRONG /boxes/0/axes/1/2");
  EXPECT_EQ(fault(box("[1,1,1]", R"("axes":[[1,0,0],[0,1,0],[0,0,1]],"rotation":[0,0,0,1])")),
            "KEYS_MIXED /boxes/0");
  EXPECT_EQ(fault(R"({"boxes":[{"center":[0,0,0],"half":[1,1,1]}]})"), "KEY_MISSING /boxes/0");
}

TEST(BoxJson, writes_lists_of_triangles_and_of_nodes) {
  BoxLists lists;
  lists.first = {0, 1, 1};
  lists.next = {0, 0};
  lists.triangles = {{2, 7}};
  HitTerms terms;
  terms.primitive = {1};
  terms.triangle = {5};
  terms.node_name = {"house"};
  terms.mesh_name = {""};
  const Column<std::uint64_t> totals{3, 0}, questions{0xabc, 0};
  EXPECT_EQ(encode_box_lists(lists, totals, BoxTargets::kTriangles, terms, 7, questions),
            R"({"results":[{"total":3,"triangles":[{"instance":2,"primitive":1,"triangle":5,)"
            R"("node":"house","mesh":null}]},{"total":0,"triangles":[]}]})");
  terms.node = {9};
  EXPECT_EQ(encode_box_lists(lists, totals, BoxTargets::kNodes, terms, 7, questions),
            R"({"results":[{"total":3,"nodes":[{"node":"house","node_id":9}]},)"
            R"({"total":0,"nodes":[]}]})");
  lists.next = {5, 0};
  EXPECT_EQ(
      encode_box_lists(lists, totals, BoxTargets::kNodes, terms, 7, questions),
      R"({"results":[{"total":3,"nodes":[{"node":"house","node_id":9}],)"
      R"("next":"00000000000000070000000000000abcn0000000000000005"},{"total":0,"nodes":[]}]})");
}

TEST(BoxJson, reads_capsules_planes_modes_and_cursors) {
  std::string body = R"({"boxes":[{"from":[1,2,3],"to":[4,5,6],"radius":7},
      {"planes":[[1,0,0,5],[0,-1,0,0.5]],"cursor":"00000000000000070000000000000abct00000001000000ff"},
      {"center":[0,0,0],"radius":1}],"mode":"contained"})";
  const auto query = decode_boxes(body, {});
  ASSERT_TRUE(query.ok()) << query.error().message;
  EXPECT_EQ(query->question.relation, BoxRelation::kContained);
  ASSERT_EQ(query->boxes.capsules.size(), 1u);
  EXPECT_EQ(query->boxes.capsules[0].to, (Vec3d{4, 5, 6}));
  EXPECT_EQ(query->boxes.capsules[0].radius, 7);
  const auto planes = query->boxes.region(0).planes;
  ASSERT_EQ(planes.size(), 2u);
  EXPECT_EQ(planes[1].normal, (Vec3d{0, -1, 0}));
  EXPECT_EQ(planes[1].offset, 0.5);
  ASSERT_EQ(query->cursors.size(), 3u);
  EXPECT_EQ(query->cursors[0].from, 0u);
  EXPECT_EQ(query->cursors[1].revision, 7u);
  EXPECT_EQ(query->cursors[1].question, 0xabcu);
  ASSERT_EQ(query->questions.size(), 3u);
  EXPECT_NE(query->questions[0], query->questions[1]);
  EXPECT_FALSE(query->cursors[1].of_nodes);
  EXPECT_EQ(query->cursors[1].from, 0x1000000ffu);
}

TEST(BoxJson, names_the_place_of_what_is_wrong_in_other_shapes) {
  const auto boxes = [](const std::string& row) { return R"({"boxes":[)" + row + "]}"; };
  EXPECT_EQ(fault(boxes(R"({"from":[0,0,0],"radius":1})")), "KEY_MISSING /boxes/0");
  EXPECT_EQ(fault(boxes(R"({"from":[0,0,0],"to":[0,0,0]})")), "KEY_MISSING /boxes/0");
  EXPECT_EQ(fault(boxes(R"({"from":[0,0,0],"to":[0,0,0],"radius":1,"half":[1,1,1]})")),
            "KEYS_MIXED /boxes/0");
  EXPECT_EQ(fault(boxes(R"({"from":[0,0,0],"to":[0,0,0],"radius":-1})")),
            "BOX_RADIUS_NEGATIVE /boxes/0/radius");
  EXPECT_EQ(fault(boxes(R"({"planes":[]})")), "BOX_PLANES_COUNT /boxes/0/planes");
  EXPECT_EQ(fault(boxes(R"({"planes":[[0,0,1,0],[0,0,0,1]]})")),
            "BOX_PLANE_ZERO /boxes/0/planes/1");
  EXPECT_EQ(fault(boxes(R"({"planes":[[0,0,1]]})")), "LENGTH_WRONG /boxes/0/planes/0");
  EXPECT_EQ(fault(boxes(R"({"planes":[[0,0,1,0]],"radius":1})")), "KEYS_MIXED /boxes/0");
  EXPECT_EQ(fault(R"({"boxes":[],"contacts":1})"), "TYPE_WRONG /contacts");
  EXPECT_EQ(fault(R"({"boxes":[],"contacts":true,"of":"nodes"})"), "KEYS_MIXED /contacts");
  EXPECT_EQ(fault(R"({"boxes":[{"center":[0,0,0],"radius":1},{"planes":[[0,0,1,0]]}],)"
                  R"("contacts":true})"),
            "BOX_CONTACTS /boxes/1");
  EXPECT_EQ(fault(boxes(R"({"hull":[]})")), "BOX_HULL_COUNT /boxes/0/hull");
  EXPECT_EQ(fault(boxes(R"({"hull":[[0,0,1],[0,0]]})")), "LENGTH_WRONG /boxes/0/hull/1");
  EXPECT_EQ(fault(boxes(R"({"hull":[[0,0,1],[0,1,null]]})")), "TYPE_WRONG /boxes/0/hull/1/2");
  EXPECT_EQ(fault(boxes(R"({"hull":[[0,0,1e999]]})")), "NUMBER_NOT_FINITE /boxes/0/hull/0/2");
  EXPECT_EQ(fault(boxes(R"({"hull":[[0,0,1]],"radius":1})")), "KEYS_MIXED /boxes/0");
  std::string points = "[1,2,3]";
  for (int i = 0; i < 256; ++i) points += ",[1,2,3]";
  EXPECT_EQ(fault(boxes(R"({"hull":[)" + points + "]}")), "BOX_HULL_COUNT /boxes/0/hull/256");
  std::string many = "[0,0,1,0]";
  for (int i = 0; i < 32; ++i) many += ",[0,0,1,0]";
  EXPECT_EQ(fault(boxes(R"({"planes":[)" + many + "]}")), "BOX_PLANES_COUNT /boxes/0/planes/32");
  const auto corners = [&](const std::string& last) {
    return fault(boxes(R"({"corners":[[0,0,0],[1,0,0],[1,1,0],[0,1,0],[0,0,1],[1,0,1],[1,1,1])" +
                       last + "]}"));
  };
  EXPECT_EQ(corners(",[0,1,1]"), "");
  EXPECT_EQ(corners(""), "LENGTH_WRONG /boxes/0/corners");
  EXPECT_EQ(corners(",[0,1,1],[0,0,0]"), "LENGTH_WRONG /boxes/0/corners");
  EXPECT_EQ(corners(",[0,1]"), "LENGTH_WRONG /boxes/0/corners/7");
  EXPECT_EQ(corners(",[0,1,-1]"), "BOX_CORNERS /boxes/0/corners");
  const auto view = [&](const std::string& camera) {
    return fault(boxes(R"({"view":{)" + camera + R"("width":4,"height":3}})"));
  };
  EXPECT_EQ(view(R"("kind":"pinhole",)"), "");
  EXPECT_EQ(view(R"("kind":"orthographic",)"), "KEY_MISSING /boxes/0/view");
  EXPECT_EQ(view(R"("kind":"pinhole","fov_y":0,)"), "NUMBER_OUT_OF_RANGE /boxes/0/view/fov_y");
  EXPECT_EQ(view(R"("kind":"equirectangular",)"), "VIEW_KIND /boxes/0/view/kind");
  EXPECT_EQ(view(R"("kind":"camera","camera":"front",)"), "CAMERA_UNKNOWN /boxes/0/view/camera");
  EXPECT_EQ(view(R"("kind":"pinhole","poses":[{},{}],)"), "KEY_UNKNOWN /boxes/0/view/poses");
  EXPECT_EQ(view(R"("kind":"pinhole","range":[2,1],)"), "RAY_LIMITS_REVERSED /boxes/0/view/range");
  EXPECT_EQ(view(R"("kind":"pinhole","range":[0,1e999],)"),
            "NUMBER_NOT_FINITE /boxes/0/view/range/1");
  const auto cursor = [&](const std::string& text) {
    return fault(boxes(R"({"min":[0,0,0],"max":[1,1,1],"cursor":)" + text + "}"));
  };
  EXPECT_EQ(cursor(R"("00000000000000070000000000000abct0000000000000005")"), "");
  EXPECT_EQ(cursor("7"), "TYPE_WRONG /boxes/0/cursor");
  for (const char* text : {"", "x", "00000000000000070000000000000abct0000000000000000",
                           "00000000000000070000000000000abcT0000000000000005",
                           "000000000000000A0000000000000abct0000000000000005"})
    EXPECT_EQ(cursor('"' + std::string(text) + '"'), "CURSOR_UNKNOWN /boxes/0/cursor") << text;
  EXPECT_EQ(
      fault(
          boxes(
              R"({"min":[0,0,0],"max":[1,1,1],"cursor":"00000000000000070000000000000abct0000000000000005"})"),
          {.has_limit = false}),
      "KEY_UNKNOWN /boxes/0/cursor");
  EXPECT_EQ(fault(R"({"boxes":[],"mode":"outside"})"), "VALUE_UNKNOWN /mode");
}

constexpr char kRay[] = R"({"origin":[0,0,0],"direction":[0,0,1]})";
constexpr char kBox[] = R"({"min":[0,0,0],"max":[1,1,1]})";

std::string pairs(const std::string& rays, const std::string& boxes, const std::string& more = "") {
  return R"({"rays":[)" + rays + R"(],"boxes":[)" + boxes + "]" + more + "}";
}

TEST(RayBoxJson, reads_rays_boxes_and_how_they_pair) {
  const std::string two =
      std::string(kRay) + R"(,{"origin":[0,0,0],"direction":[-0.0,0,1],"tmin":2})";
  std::string body = pairs(two, kBox, R"(,"pairing":"all","line":true,"planes":true)");
  auto query = decode_ray_boxes(body, {});
  ASSERT_TRUE(query.ok()) << query.error().message;
  EXPECT_EQ(query->pairing, BoxPairing::kAll);
  EXPECT_TRUE(query->planes);
  EXPECT_EQ(query->rays.tmin[0], -kInf) << "a line";
  EXPECT_EQ(query->rays.tmin[1], 2) << "a limit that is given holds";
  EXPECT_EQ(query->rays.tmax[0], kInf);
  EXPECT_TRUE(std::signbit(query->rays.dx[1]));

  // "line" may come first, and columns do as well.
  body =
      R"({"line":false,"boxes":[{"min":[0,0,0],"max":[1,1,1]}],"origins":[1,2,3],"directions":[4,5,6]})";
  query = decode_ray_boxes(body, {});
  ASSERT_TRUE(query.ok()) << query.error().message;
  EXPECT_EQ(query->pairing, BoxPairing::kEach);
  EXPECT_EQ(query->rays.tmin[0], 0);
  EXPECT_EQ(query->rays.size(), 1u);
}

TEST(RayBoxJson, names_the_place_of_what_is_wrong) {
  EXPECT_EQ(pair_fault("{}"), "KEY_MISSING ");
  EXPECT_EQ(pair_fault(R"({"rays":[]})"), "KEY_MISSING ");
  EXPECT_EQ(pair_fault(pairs(kRay, "")), "PAIRS_UNEQUAL /boxes");
  EXPECT_EQ(pair_fault(pairs(kRay, "", R"(,"pairing":"all")")), "");
  EXPECT_EQ(pair_fault(pairs(kRay, kBox, R"(,"pairing":"some")")), "VALUE_UNKNOWN /pairing");
  EXPECT_EQ(pair_fault(pairs(kRay, kBox, R"(,"line":1)")), "TYPE_WRONG /line");
  EXPECT_EQ(pair_fault(pairs(kRay, kBox, R"(,"planes":"yes")")), "TYPE_WRONG /planes");
  EXPECT_EQ(pair_fault(pairs(kRay, kBox, R"(,"fields":["t"])")), "KEY_UNKNOWN /fields");
  EXPECT_EQ(pair_fault(pairs(kRay, kBox, R"(,"line":true,"line":true)")), "KEY_DUPLICATE /line");
  EXPECT_EQ(pair_fault(pairs(R"({"origin":[0,0,0],"direction":[0,-0.0,0]})", kBox)),
            "RAY_DIRECTION_ZERO /rays/0/direction");
  EXPECT_EQ(pair_fault(pairs(R"({"origin":[0,0,0],"direction":[0,1,0],"tmax":-1})", kBox)),
            "RAY_LIMITS_REVERSED /rays/0/tmax");
  EXPECT_EQ(pair_fault(pairs(R"({"origin":[0,0,0],"direction":[0,1,0],"tmax":-1})", kBox,
                             R"(,"line":true)")),
            "");
  EXPECT_EQ(pair_fault(pairs(kRay, R"({"min":[0,0,0],"max":[1,-1,1]})")),
            "BOX_REVERSED /boxes/0/min/1");
  const std::string two_rays = std::string(kRay) + "," + kRay,
                    two_boxes = std::string(kBox) + "," + kBox;
  EXPECT_EQ(pair_fault(pairs(two_rays, two_boxes, R"(,"pairing":"all")"), {.max_pairs = 3}),
            "PAIRS_TOO_MANY /boxes");
  EXPECT_EQ(pair_fault(pairs(two_rays, two_boxes), {.max_pairs = 3}), "");
}

TEST(RayBoxJson, refuses_every_proper_prefix_of_a_good_body) {
  const std::string whole =
      pairs(kRay, R"({"center":[0,0,0],"half":[1,1,null],"axes":[[1,0,0],[0,1,0],[0,0,1]]})",
            R"(,"pairing":"each","line":true)");
  for (std::size_t length = 0; length < whole.size(); ++length) {
    std::string body(whole.data(), length);
    body.shrink_to_fit();
    ASSERT_FALSE(decode_ray_boxes(body, {}).ok()) << body;
    std::string other(whole.data(), length);
    ASSERT_FALSE(decode_boxes(other, {}).ok()) << other;
  }
  std::string body = whole;
  EXPECT_TRUE(decode_ray_boxes(body, {}).ok());
}

TEST(RayBoxJson, writes_hits_and_misses) {
  RayBoxAnswers answers;
  answers.resize(4, RayBoxDetail::kAll);
  answers.outcome = {RayBoxOutcome::kHit, RayBoxOutcome::kApart, RayBoxOutcome::kBeside,
                     RayBoxOutcome::kBehind};
  answers.t[0] = 8;
  answers.t_enter[0] = 8;
  answers.t_exit[0] = kInf;
  answers.faces[0].add({0, false});
  answers.faces[0].add({1, true});
  answers.normal[0] = {-1, 0, 0};
  answers.apart[1] = {0, 2};
  answers.apart[2] = {1, 1};
  answers.t_enter[3] = -12;
  answers.t_exit[3] = -0.5;
  EXPECT_EQ(encode_ray_boxes(answers),
            R"({"results":[{"hit":true,"t":8,"t_enter":8,"t_exit":null,"inside":false,)"
            R"("on_surface":false,"face":"-x","faces":["-x","+y"],"normal":[-1,0,0]},)"
            R"({"hit":false,"miss":["x","z"]},{"hit":false,"miss":["y"]},)"
            R"({"hit":false,"miss":"behind","t_enter":-12,"t_exit":-0.5,"inside":false,)"
            R"("on_surface":false}]})");
}

TEST(RayBoxJson, writes_planes_and_rays_that_end_inside) {
  RayBoxAnswers answers;
  answers.resize(1, RayBoxDetail::kPlanes);
  answers.outcome[0] = RayBoxOutcome::kHit;
  answers.inside[0] = 1;
  answers.t[0] = kInf;
  answers.t_enter[0] = -2;
  answers.t_exit[0] = 4;
  answers.planes[0] = {-2, 4, std::nullopt, std::nullopt, 1e300, kInf};
  EXPECT_EQ(encode_ray_boxes(answers),
            R"({"results":[{"hit":true,"t":null,"t_enter":-2,"t_exit":4,"inside":true,)"
            R"("on_surface":false,"face":null,"faces":[],"normal":null,)"
            R"("planes":[-2,4,null,null,1e+300,null]}]})");
}

}  // namespace
}  // namespace sightline
