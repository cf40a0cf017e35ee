// The decoder against broken text: every prefix, and random damage judged by another parser.

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <iostream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "proto/json/ray_json.h"

namespace sightline {
namespace {

const char* const kBodies[] = {
    R"({"rays":[{"origin":[1.5,-2e3,0.0],"direction":[0,-0.0,1e-5],"tmin":0,"tmax":1e30},
        {"direction":[1,2,3],"origin":[4,5,6],"tmax":null}],"fields":["t","node","position"]})",
    R"({"origins":[1,2,3,4.25,5,6],"directions":[0,0,1,0,1,-0],"tmin":[-1,0],"tmax":[2,null]})",
};

/// What another parser says that the body means: must be what decode_rays made of it.
void expect_same_rays(const std::string& body, const RayQuery& query) {
  const auto document = nlohmann::json::parse(body, nullptr, false);
  ASSERT_FALSE(document.is_discarded()) << "accepted, but not JSON: " << body;
  const auto same = [](const nlohmann::json& number, double value) {
    // nlohmann reads "-0" as the integer 0: its sign is lost there, not here.
    const double other = number.get<double>();
    return std::bit_cast<std::uint64_t>(other) == std::bit_cast<std::uint64_t>(value) ||
           (other == 0 && value == 0 && number.is_number_integer());
  };
  const bool rows = query.layout == AnswerLayout::kRows;
  for (std::size_t i = 0; i < query.rays.size(); ++i) {
    const Ray ray = query.rays[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& origin = rows ? document["rays"][i]["origin"][k] : document["origins"][3 * i + k];
      const auto& direction =
          rows ? document["rays"][i]["direction"][k] : document["directions"][3 * i + k];
      ASSERT_TRUE(same(origin, ray.origin[static_cast<int>(k)])) << body;
      ASSERT_TRUE(same(direction, ray.direction[static_cast<int>(k)])) << body;
    }
  }
}

TEST(RayJsonHostile, refuses_every_proper_prefix_of_a_good_body) {
  for (const char* const good : kBodies) {
    const std::string whole = good;
    for (std::size_t length = 0; length < whole.size(); ++length) {
      // Exactly sized, so that the memory checkers see a read past the end.
      std::string body(whole.data(), length);
      body.shrink_to_fit();
      const auto query = decode_rays(body, {});
      ASSERT_FALSE(query.ok()) << body;
      EXPECT_FALSE(query.error().code.empty());
    }
    std::string body = whole;
    EXPECT_TRUE(decode_rays(body, {}).ok());
  }
}

TEST(RayJsonHostile, accepts_after_random_damage_only_what_another_parser_reads_alike) {
  constexpr std::uint64_t kSeed = 20240611;
  std::cout << "seed " << kSeed << "\n";
  std::mt19937_64 random(kSeed);
  const std::string alphabet = "{}[]:,\"\\0123456789.eE+-aINn \t\n\x80\xff";
  int accepted = 0;
  for (int round = 0; round < 40000; ++round) {
    std::string body = kBodies[random() % std::size(kBodies)];
    for (std::uint64_t edit = random() % 3 + 1; edit > 0; --edit) {
      const std::size_t at = random() % body.size();
      switch (random() % 4) {
        case 0:
          body[at] = alphabet[random() % alphabet.size()];
          break;
        case 1:
          body.erase(at, random() % 4 + 1);
          break;
        case 2:
          body.insert(at, 1, alphabet[random() % alphabet.size()]);
          break;
        default:
          body.insert(at, body.substr(random() % body.size(), random() % 16));
          break;
      }
      if (body.empty()) body = "{";
    }
    const std::string sent = body;
    const auto query = decode_rays(body, {});
    ASSERT_EQ(body, sent);
    if (query.ok()) {
      ++accepted;
      expect_same_rays(sent, query.value());
      if (HasFatalFailure()) return;
    }
  }
  std::cout << "still good after damage: " << accepted << " of 40000\n";
  EXPECT_GT(accepted, 1000);
}

TEST(RayJsonHostile, survives_deep_nesting_and_long_numbers) {
  for (std::string body :
       {std::string(200000, '['),
        "{\"rays\":" + std::string(200000, '[') + std::string(200000, ']') + "}",
        "{\"rays\":[{\"origin\":[" + std::string(200000, '9') + ",0,0],\"direction\":[0,0,1]}]}",
        "{\"rays\":[{\"origin\":[0." + std::string(200000, '0') + "1,0,0],\"direction\":[0,0,0]}]}",
        "{\"rays\":[],\"fields\":[\"" + std::string(200000, 't') + "\"]}"}) {
    EXPECT_FALSE(decode_rays(body, {}).ok());
  }
}

}  // namespace
}  // namespace sightline
