#include "server/operation/config_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "server/operation/cli.h"

namespace sightline {
namespace {

class ConfigFile : public testing::Test {
 protected:
  ConfigFile() { std::filesystem::create_directories(folder_); }
  ~ConfigFile() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) const {
    std::string file = folder_ / name;
    std::ofstream(file) << text;
    return file;
  }
  std::vector<std::string> mistakes(const std::string& text) const {
    return report_of_config(write("config", text)).mistakes;
  }
  /// What a server would be told, without the file's own name.
  static std::vector<FlagText> flags(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"sightline", "serve"});
    const Command command = parse_command_line(arguments);
    if (const auto* shown = std::get_if<ShowText>(&command)) ADD_FAILURE() << shown->text;
    const auto* serve = std::get_if<ServeCommand>(&command);
    auto texts = serve == nullptr ? std::vector<FlagText>() : serve->flags;
    std::erase_if(texts, [](const FlagText& text) { return text.name == "config"; });
    return texts;
  }

  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("config" + std::to_string(::getpid()));
};

TEST_F(ConfigFile, says_the_same_as_each_flag) {
  const std::string keys = write("keys", ""), folder = folder_;
  // A value for each flag that is not its default, as JSON.
  std::map<std::string, std::string> samples{
      {"listen", "\"[::1]:1\""},
      {"keys", '"' + keys + '"'},
      {"insecure", "true"},
      {"data", '"' + folder + "/d\""},
      {"cors-origin", R"(["https://a.example", "*"])"},
      {"preload", R"(["a=demo:six", "b=demo:town"])"},
      {"threads", "3"},
      {"kernel", "\"baseline\""},
      {"log-level", "\"warn\""},
      {"log-format", "\"json\""},
      {"skip", "\"none\""},
      {"memory-budget", "123456789"},
      {"cache-bytes", "123456789"},
      {"origin", "\"s3://bucket/prefix\""},
      {"origin-credentials", '"' + keys + '"'},
      {"memory", "123456789"},
      {"spool-dir", '"' + folder + '"'},
      {"scene-root", '"' + folder + '"'},
      {"allow-url", R"(["https://a.example/", "http://b:1/"])"},
      {"allow-address", "\"10.0.0.0/8\""}};
  for (const FlagText& flag : flags({})) {
    if (flag.name == "help") continue;
    SCOPED_TRACE(flag.name);
    std::string value = samples.contains(flag.name) ? samples[flag.name] : "";
    // The others are numbers, and one more than the default is good for each.
    if (value.empty()) value = std::to_string(std::stoull(flag.text) + 1);
    // An origin needs a cache.
    const std::string first = flag.name == "origin" ? "\"data\": " + samples["data"] + ", " : "";
    std::string text = "{" + first;
    text.append("\"").append(flag.name).append("\": ").append(value).append("}");
    const std::string file = write("config", text);
    EXPECT_EQ(report_of_config(file).mistakes, std::vector<std::string>());
    std::vector<std::string> mistakes, given;
    for (const Setting& setting : read_config(file, mistakes)) append_flags(setting, given);
    EXPECT_FALSE(given.empty());
    const auto by_file = flags({"--config", file}), by_flag = flags(given);
    EXPECT_EQ(by_file, by_flag);
    EXPECT_NE(by_file, flags({}));
  }
}

TEST_F(ConfigFile, goes_behind_flags_that_are_given) {
  const std::string file =
      write("config", R"({"max-rays": 5, "max-hits": 6, "preload": ["a=demo:six"]})");
  EXPECT_EQ(flags({"--config", file, "--max-rays", "7", "--preload", "b=demo:six"}),
            flags({"--max-hits", "6", "--max-rays", "7", "--preload", "b=demo:six"}));
}

TEST_F(ConfigFile, may_have_comments) {
  EXPECT_TRUE(mistakes("// for the town\n{ /* few */ \"max-rays\": 1000 }\n").empty());
  EXPECT_TRUE(mistakes("{}").empty());
  EXPECT_TRUE(mistakes("{\"preload\": [], \"insecure\": false}").empty());
}

TEST_F(ConfigFile, names_every_mistake_with_its_line) {
  const auto found = mistakes(R"({
    "max-rays": 0,
    "max-hits": "many",
    "max-rais": 5,
    "listen": {"port": 80},
    "data": null,
    "threads": [1, 2],
    "idle-seconds": true,
    "config": "x",
    "preload": [["a"]],
    "max-loads": 5,
    "max-loads": 6,
    "skip": "",
    "help": true,
    "log-level": "loud"
})");
  const std::vector<std::string> wanted{
      "5: listen: ",   "6: data: ",     "10: preload: ",  "12: max-loads: ", "13: skip: ",
      "2: max-rays: ", "3: max-hits: ", "4: max-rais: ",  "7: threads: ",    "8: idle-seconds: ",
      "9: config: ",   "14: help: ",    "15: log-level: "};
  ASSERT_EQ(found.size(), wanted.size()) << testing::PrintToString(found);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    EXPECT_NE(found[i].find("/config:" + wanted[i]), std::string::npos) << found[i];
  }
}

TEST_F(ConfigFile, is_one_object_of_good_json) {
  for (const char* text :
       {"", "[]", "5", "\"x\"", "null", "{", "{\"a\"}", "{\"max-rays\": 5,}", "{\"threads\": 05}",
        "{} {}", "{\"max-rays\": 5} x", "\xff", "{'a': 1}", "[[[[[[[["}) {
    EXPECT_EQ(mistakes(text).size(), 1u) << text;
  }
  EXPECT_NE(mistakes("{\n\n\"max-rays\": 5 5}")[0].find("config:3: "), std::string::npos);
  EXPECT_EQ(mistakes(std::string(100'000, '[')).size(), 1u);
  EXPECT_EQ(mistakes(std::string((1 << 20) + 1, ' ')).size(), 1u);
  EXPECT_EQ(report_of_config(folder_).mistakes.size(), 1u);
  EXPECT_EQ(report_of_config(folder_ / "none").mistakes.size(), 1u);
  EXPECT_EQ(report_of_config("/dev/zero").mistakes.size(), 1u);
}

TEST_F(ConfigFile, is_also_checked_as_a_whole) {
  EXPECT_EQ(mistakes(R"({"listen": "0.0.0.0:80"})").size(), 1u);
  EXPECT_TRUE(mistakes(R"({"listen": "0.0.0.0:80", "insecure": true})").empty());
  const std::string keys = write("keys", "read\n");
  const auto found = mistakes(R"({"keys": ")" + keys + "\"}");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].find("line 1 of the keys"), std::string::npos) << found[0];
}

}  // namespace
}  // namespace sightline
