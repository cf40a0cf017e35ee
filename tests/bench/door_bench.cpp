/// Trivial requests over keep-alive connections: Sightline's door beside cpp-httplib as it comes
/// with the same number of workers, and beside nginx. Rounds take turns; medians of all rounds.

#include <CLI/CLI.hpp>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "tests/bench/http_servers.h"
#include "tests/bench/load_client.h"
#include "tests/bench/machine.h"
#include "tests/bench/statistics.h"

namespace sightline::bench {
namespace {

struct Contestant {
  std::string name;
  ServerProcess server;
  std::vector<double> per_second{}, cpu_us{};
  std::uint64_t failed = 0;
};

struct Options {
  std::string out = "build/bench";
  std::string binary =
      (std::filesystem::canonical("/proc/self/exe").parent_path() / "../../sightline")
          .lexically_normal()
          .string();
  int connections = 64, workers = 32, rounds = 7;
  double seconds = 2;
  bool quick = false;
};

void measure(Contestant& contestant, const Options& options) {
  const std::string request = "GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
  const double before = contestant.server.cpu_us();
  const LoadResult load =
      put_load(contestant.server.port(), options.connections, request, options.seconds);
  const double used = contestant.server.cpu_us() - before;
  const auto answers = static_cast<double>(std::max<std::uint64_t>(load.answers, 1));
  contestant.per_second.push_back(answers / load.seconds);
  contestant.cpu_us.push_back(used / answers);
  contestant.failed += load.failed;
}

/// Median of the quotients of rounds that ran beside each other.
double median_quotient(const std::vector<double>& above, const std::vector<double>& below) {
  std::vector<double> quotients;
  for (std::size_t i = 0; i < above.size(); ++i) quotients.push_back(above[i] / below[i]);
  return spread_of(quotients).median;
}

void report(const std::vector<Contestant>& contestants, const Options& options) {
  nlohmann::ordered_json document{{"machine", machine_name()},
                                  {"connections", options.connections},
                                  {"workers", options.workers},
                                  {"rounds", options.rounds},
                                  {"seconds", options.seconds}};
  std::printf("%-14s %14s %18s %8s\n", "server", "requests/s", "CPU us/request", "failed");
  for (const Contestant& each : contestants) {
    const double rate = spread_of(each.per_second).median, cpu = spread_of(each.cpu_us).median;
    std::printf("%-14s %14.0f %18.2f %8llu\n", each.name.c_str(), rate, cpu,
                static_cast<unsigned long long>(each.failed));
    document["servers"].push_back({{"name", each.name},
                                   {"requests_per_second", rate},
                                   {"cpu_us_per_request", cpu},
                                   {"failed", each.failed},
                                   {"rounds_per_second", each.per_second},
                                   {"rounds_cpu_us", each.cpu_us}});
  }
  const Contestant &ours = contestants[0], &plain = contestants[1], &nginx = contestants[2];
  const double throughput = median_quotient(ours.per_second, plain.per_second);
  const double cpu = median_quotient(ours.cpu_us, nginx.cpu_us);
  document["throughput_to_plain"] = throughput;
  document["cpu_to_nginx"] = cpu;
  std::ofstream(options.out + "/door.json") << document.dump(2) << "\n";
  const bool clean = ours.failed == 0;
  std::printf("floor 2: throughput %.2f of plain cpp-httplib (needs 1.3) %s\n", throughput,
              throughput >= 1.3 && clean ? "ok" : "short");
  std::printf("floor 2: server CPU %.2f of nginx (needs at most 2.0) %s\n", cpu,
              cpu <= 2.0 && clean ? "ok" : "short");
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Sightline's door beside cpp-httplib and nginx.");
  app.add_option("--out", options.out, "folder for door.json")->capture_default_str();
  app.add_option("--binary", options.binary, "sightline")->capture_default_str();
  app.add_option("--connections", options.connections)->capture_default_str();
  app.add_option("--workers", options.workers)->capture_default_str();
  app.add_option("--rounds", options.rounds)->capture_default_str();
  app.add_option("--seconds", options.seconds, "of each round")->capture_default_str();
  app.add_flag("--quick", options.quick, "3 rounds of a second");
  CLI11_PARSE(app, argc, argv);
  if (options.quick) {
    options.rounds = 3;
    options.seconds = 1;
  }
  options.out = std::filesystem::absolute(options.out).string();
  std::filesystem::create_directories(options.out);
  std::vector<Contestant> contestants;
  contestants.push_back({"sightline", ServerProcess::sightline(options.binary, options.workers)});
  contestants.push_back({"cpp-httplib", ServerProcess::plain(options.workers)});
  contestants.push_back({"nginx", ServerProcess::nginx(options.out)});
  for (int round = 0; round < options.rounds; ++round) {
    for (Contestant& each : contestants) measure(each, options);
  }
  report(contestants, options);
  return 0;
}

}  // namespace
}  // namespace sightline::bench

int main(int argc, char** argv) {
  try {
    return sightline::bench::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "door_bench: " << error.what() << "\n";
    return 1;
  }
}
