// Rays as lines, in batches cut anywhere between lines; and as frames.

#include "proto/json/ray_lines.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>

#include "proto/binary/ray_frames.h"
#include "tests/oracle/random.h"

namespace sightline {
namespace {

const std::string kPlainRay = R"({"origin":[1,2,3],"direction":[0,0,-1],"tmax":9})";

TEST(RayLines, are_rays_in_their_order_after_the_options) {
  RayLines lines({});
  std::string first = R"({"options":{"fields":["t"],"cull":"back"}})"
                      "\n" +
                      kPlainRay + "\n\n  \r\n";
  const auto one = lines.decode(first);
  ASSERT_TRUE(one.ok());
  EXPECT_EQ(one->rays.size(), 1u);
  EXPECT_EQ(one->layout, AnswerLayout::kLines);
  EXPECT_EQ(one->fields, (FieldSet{HitField::kT}));
  std::string second = R"({"direction":[0,1,0],"origin":[4,5,6]})"
                       "\n" +
                       kPlainRay;
  const auto two = lines.decode(second);
  ASSERT_TRUE(two.ok());
  ASSERT_EQ(two->rays.size(), 2u);
  EXPECT_EQ(two->rays[0].origin, (Vec3d{4, 5, 6}));
  EXPECT_EQ(two->rays[1].tmax, 9);
  EXPECT_EQ(two->filter.culling, Culling::kBack) << "the options stay";
  std::string third = kPlainRay + "\n{}\n";
  const auto bad = lines.decode(third);
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().pointer, "/rays/4") << "counted from the first";
}

TEST(RayLines, refuses_what_is_not_one_object_in_one_line) {
  for (const std::string& line :
       {kPlainRay + kPlainRay, std::string(kPlainRay).append(",").append(kPlainRay),
        "[" + kPlainRay + "]", kPlainRay + "]}", kPlainRay.substr(0, 30),
        kPlainRay + R"(],"fields":["t")", std::string("7"), std::string("\"x\""),
        std::string("null")}) {
    RayLines lines({});
    std::string text = kPlainRay;
    text.append("\n").append(line).append("\n").append(kPlainRay);
    EXPECT_FALSE(lines.decode(text).ok()) << line;
  }
  RayLines lines({});
  std::string options = R"({"options":{}, "fields":["t"]})"
                        "\n" +
                        kPlainRay;
  EXPECT_FALSE(lines.decode(options).ok());
}

TEST(RayLines, survives_any_damage) {
  oracle::Random random(88);
  std::size_t good = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text = R"({"options":{"on_invalid":"mark"}})"
                       "\n";
    for (int k = random.integer(0, 3); k > 0; --k) text += kPlainRay + "\n";
    for (int k = random.integer(0, 3); k > 0; --k)
      text[random.index(text.size())] = "\n\0{}[]\",:1e-"[random.index(12)];
    RayLines lines({});
    good += lines.decode(text).ok() ? 1u : 0u;
  }
  std::printf("still good after damage: %zu of 20000\n", good);
}

std::string request(std::uint64_t rays, const std::string& options) {
  std::string body(24, '\0');
  const std::uint32_t flags = 1, length = static_cast<std::uint32_t>(options.size());
  std::memcpy(body.data(), "SLR1", 4);
  std::memcpy(body.data() + 4, &flags, 4);
  std::memcpy(body.data() + 8, &rays, 8);
  std::memcpy(body.data() + 16, &length, 4);
  body += options;
  body.resize((body.size() + 7) / 8 * 8);
  const std::string number("\0\0\0\0\0\0\xf0\x3f", 8);
  for (std::uint64_t i = 0; i < 6 * rays; ++i) body += number;
  return body;
}

TEST(RayFrames, keep_the_first_options) {
  RayFrames frames({});
  EXPECT_EQ(frames.decode(request(2, R"({"fields":["t"],"normalize":true})"))->rays.size(), 2u);
  const auto second = frames.decode(request(3, ""));
  ASSERT_TRUE(second.ok());
  EXPECT_EQ(second->rays.size(), 3u);
  EXPECT_TRUE(second->normalize);
  EXPECT_EQ(second->fields, (FieldSet{HitField::kT}));
  EXPECT_FALSE(frames.decode(request(1, R"({"normalize":false})"))->normalize);
  EXPECT_TRUE(frames.decode(request(1, ""))->normalize);
}

TEST(RayFrames, say_how_long_they_are) {
  EXPECT_EQ(*read_frame_length(framed("abc")), 3u);
  EXPECT_EQ(read_frame_length(std::string(8, '\xff')).error().code, "FRAME_TOO_LARGE");
  EXPECT_TRUE(check_stream_header(std::string("SLS1\0\0\0\0", 8)).ok());
  EXPECT_FALSE(check_stream_header("SLS1").ok());
}

}  // namespace
}  // namespace sightline
