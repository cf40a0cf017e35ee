#include "server/operation/cli.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline {
namespace {

Command parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "sightline");
  return parse_command_line({arguments.begin(), arguments.end()});
}

TEST(CommandLine, reads_serve) {
  const Command command =
      parse({"serve", "--listen", "[::1]:0", "--data", "d", "--preload", "a=demo:six", "--preload",
             "b=demo:town", "--threads", "3", "--drain-seconds", "1.5"});
  const auto& serve = std::get<ServeCommand>(command);
  EXPECT_EQ(serve.listen.host, "::1");
  EXPECT_EQ(serve.listen.port, 0);
  EXPECT_EQ(serve.data, "d");
  ASSERT_EQ(serve.preloads.size(), 2u);
  EXPECT_EQ(serve.preloads[1], (std::pair<std::string, std::string>("b", "demo:town")));
  EXPECT_EQ(serve.threads, 3);
  EXPECT_EQ(serve.limits.drain.get(), std::chrono::milliseconds(1500));
}

TEST(CommandLine, reads_numbers_of_a_ray_exactly) {
  const Command command =
      parse({"cast", "f", "--origin", "-0.0,0.1,1e-320", "--direction=-1,0,9007199254740993",
             "--tmin", "-5", "--tmax", "inf"});
  const auto& cast = std::get<CastCommand>(command);
  EXPECT_TRUE(std::signbit(cast.ray.origin.x));
  EXPECT_EQ(cast.ray.origin.y, 0.1);
  EXPECT_EQ(cast.ray.origin.z, 1e-320);
  EXPECT_EQ(cast.ray.direction, (Vec3d{-1, 0, 9007199254740992.0}));
  EXPECT_EQ(cast.ray.tmin, -5);
  EXPECT_TRUE(std::isinf(cast.ray.tmax));
}

TEST(CommandLine, reads_what_is_asked_of_a_ray) {
  const auto cast = [](std::vector<const char*> more) {
    more.insert(more.begin(), {"cast", "f", "--origin", "0,0,0", "--direction", "0,0,1"});
    return std::get<CastCommand>(parse(more));
  };
  EXPECT_EQ(cast({}).mode, CastMode::kClosest);
  EXPECT_EQ(cast({"--any"}).mode, CastMode::kAny);
  EXPECT_EQ(cast({"--all"}).mode, CastMode::kAll);
  EXPECT_EQ(cast({"--all"}).crossings, Crossings::kEvery);
  EXPECT_EQ(cast({"--count", "--crossings", "once"}).mode, CastMode::kCount);
  EXPECT_EQ(cast({"--count", "--crossings", "once"}).crossings, Crossings::kOnce);
}

TEST(CommandLine, refuses_with_exit_code_2) {
  for (const std::vector<const char*>& bad : std::vector<std::vector<const char*>>{
           {},
           {"dance"},
           {"serve", "--listen", "8080"},
           {"serve", "--preload", "x"},
           {"serve", "--preload", ".x=demo:six"},
           {"serve", "--log-level", "loud"},
           {"serve", "--kernel", "mmx"},
           {"serve", "--data", ""},
           {"serve", "--preload", "a=demo:six", "--preload", "a=demo:town"},
           {"serve", "--listen", "0.0.0.0:1"},
           {"serve", "--listen", "[::]:1"},
           {"serve", "--listen", "example.org:1"},
           {"serve", "--keys", "/no/such/file"},
           {"key"},
           {"key", "new"},
           {"key", "new", "--role", "read", "--name", ".a"},
           {"key", "new", "--role", "all", "--name", "a"},
           {"serve", "--idle-seconds", "0"},
           {"serve", "--idle-seconds", "nan"},
           {"serve", "--idle-seconds", "inf"},
           {"serve", "--request-seconds", "0"},
           {"serve", "--request-seconds", "-1"},
           {"serve", "--request-seconds", "1e-9"},
           {"serve", "--drain-seconds", "nan"},
           {"serve", "--max-rays", "-1"},
           {"serve", "--max-rays", "0"},
           {"serve", "--max-hits", "99999999999999999999"},
           {"serve", "--max-query-bytes", "-1"},
           {"serve", "--max-scene-bytes", "-1"},
           {"cast", "f"},
           {"cast", "f", "--origin", "1,2", "--direction", "1,2,3"},
           {"cast", "f", "--origin", "1,2,3", "--direction", "1,2,3", "--all", "--count"},
           {"cast", "f", "--origin", "1,2,3", "--direction", "1,2,3", "--crossings", "once"},
           {"cast", "f", "--origin", "1,2,3", "--direction", "1,2,3", "--all", "--crossings",
            "twice"}}) {
    const Command command = parse(bad);
    ASSERT_TRUE(std::holds_alternative<ShowText>(command));
    EXPECT_EQ(std::get<ShowText>(command).exit_code, 2);
    EXPECT_FALSE(std::get<ShowText>(command).text.empty());
  }
  EXPECT_EQ(std::get<ShowText>(parse({"--version"})).exit_code, 0);
  EXPECT_TRUE(std::holds_alternative<ServeCommand>(parse({"serve", "--drain-seconds", "0"})));
  for (const char* local : {"localhost:1", "127.9.9.9:1", "[::1]:1", "[::ffff:127.0.0.1]:1"}) {
    EXPECT_TRUE(std::holds_alternative<ServeCommand>(parse({"serve", "--listen", local}))) << local;
  }
  EXPECT_TRUE(std::holds_alternative<ServeCommand>(
      parse({"serve", "--listen", "0.0.0.0:1", "--insecure"})));
  EXPECT_EQ(std::get<KeyCommand>(parse({"key", "new", "--role", "write", "--name", "a"})).access,
            Access::kWrite);
}

TEST(CommandLine, reads_listen_addresses) {
  const auto named = parse_listen_address("localhost:80");
  ASSERT_TRUE(named.ok());
  EXPECT_EQ(named->host, "localhost");
  EXPECT_EQ(named->port, 80);
  for (const char* bad : {"", ":", ":80", "host", "host:", "host:x", "host:-1", "host:65536",
                          "::1:80", "[]:80", "host:80 "}) {
    EXPECT_FALSE(parse_listen_address(bad).ok()) << bad;
  }
}

}  // namespace
}  // namespace sightline
