#include "server/service/scene_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace sightline {
namespace {

StoredScene ready(SceneDescription description) {
  StoredScene stored;
  stored.id = "s";
  stored.state = SceneState::kReady;
  stored.revision = 3;
  stored.sha256 = "ab";
  stored.bytes = 12;
  stored.scene = *Scene::build(std::move(description));
  return stored;
}

TEST(SceneJson, describes_a_scene_without_triangles) {
  const auto document = nlohmann::json::parse(encode_scene(ready({})));
  EXPECT_EQ(document["state"], "ready");
  EXPECT_EQ(document["revision"], 3);
  EXPECT_EQ(document["counts"]["triangles"], 0);
  EXPECT_TRUE(document["bounds"].is_null());
}

TEST(SceneJson, repairs_names_and_cuts_endless_warnings) {
  SceneDescription description;
  description.name = "bad \xff name";
  description.warnings.assign(1000, "node 7: \"quoted\"\n");
  const auto document = nlohmann::json::parse(encode_scene(ready(std::move(description))));
  EXPECT_EQ(document["name"], "bad \xef\xbf\xbd name");
  EXPECT_EQ(document["warnings"].size(), 100u);
  EXPECT_EQ(document["warnings_total"], 1000);
}

TEST(SceneJson, gives_the_reason_of_a_failure) {
  StoredScene stored;
  stored.id = "s";
  stored.state = SceneState::kFailed;
  stored.failure = Error{ErrorKind::kInvalid, "BAD", "it is bad", ""};
  const auto document = nlohmann::json::parse(encode_scene(stored));
  EXPECT_EQ(document["state"], "failed");
  EXPECT_EQ(document["reason"]["code"], "BAD");
  EXPECT_FALSE(document.contains("sha256"));
}

}  // namespace
}  // namespace sightline
