#include "proto/binary/ray_binary.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>

#include "tests/oracle/random.h"

namespace sightline {
namespace {

template <class T>
void put(std::string& body, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  body.append(bytes, sizeof(T));
}

/// Two rays as float64 with a tmax.
std::string sample(const std::string& options = "") {
  std::string body = "SLR1";
  put<std::uint32_t>(body, 5);
  put<std::uint64_t>(body, 2);
  put<std::uint32_t>(body, static_cast<std::uint32_t>(options.size()));
  put<std::uint32_t>(body, 0);
  body += options;
  while (body.size() % 8 != 0) body += 'x';
  for (const double x : {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, -0.0, 1.0, 8.0, 0.0, 0.0, 0.0, 9.0, 1e300})
    put(body, x);
  return body;
}

TEST(RayBinary, reads_columns) {
  const auto query = decode_rays_binary(sample(R"({"fields":["t"]})"), {});
  ASSERT_TRUE(query.ok());
  ASSERT_EQ(query->rays.size(), 2u);
  EXPECT_EQ(query->layout, AnswerLayout::kBinary);
  EXPECT_EQ(query->fields, (FieldSet{HitField::kT}));
  const Ray first = query->rays[0], second = query->rays[1];
  EXPECT_EQ(first.origin, (Vec3d{1, 3, 5}));
  EXPECT_EQ(second.origin, (Vec3d{2, 4, 6}));
  EXPECT_TRUE(std::signbit(first.direction.x));
  EXPECT_EQ(second.direction, (Vec3d{1, 0, 0}));
  EXPECT_EQ(first.tmin, 0);
  EXPECT_EQ(second.tmax, 1e300);
  EXPECT_EQ(decode_rays_binary(sample(), {})->fields, kDefaultBinaryFields);
}

TEST(RayBinary, refuses_every_other_length_and_survives_any_damage) {
  const std::string good = sample(R"({"work":true})");
  ASSERT_TRUE(decode_rays_binary(good, {}).ok());
  for (std::size_t length = 0; length < good.size(); ++length) {
    const auto query = decode_rays_binary(std::string_view(good).substr(0, length), {});
    ASSERT_FALSE(query.ok()) << length;
    EXPECT_EQ(query.error().code, "BINARY_MALFORMED");
  }
  oracle::Random random(63);
  std::size_t still_good = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string body = good;
    for (int k = random.integer(1, 4); k > 0; --k)
      body[random.index(body.size())] = static_cast<char>(random.integer(0, 255));
    if (random.chance(0.2)) body.resize(random.index(body.size() + 9));
    still_good += decode_rays_binary(body, {.max_rays = 100}).ok() ? 1u : 0u;
  }
  std::printf("still good after damage: %zu of 20000\n", still_good);
}

}  // namespace
}  // namespace sightline
