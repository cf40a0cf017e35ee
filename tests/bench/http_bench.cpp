/// Rays over HTTP, in every form and size of request: rays per second and processor time of the
/// server, beside the same batch in process, the codec alone, the trivial handler, and Embree
/// behind the same server. Rounds take turns; medians of all rounds.

#include <CLI/CLI.hpp>

#include <httplib.h>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "tests/bench/bench_rays.h"
#include "tests/bench/embree_server.h"
#include "tests/bench/http_alone.h"
#include "tests/bench/http_servers.h"
#include "tests/bench/load_client.h"
#include "tests/bench/machine.h"
#include "tests/bench/statistics.h"

namespace sightline::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string out = "build/bench", scene = "scan";
  std::string binary =
      (std::filesystem::canonical("/proc/self/exe").parent_path() / "../../sightline")
          .lexically_normal()
          .string();
  unsigned smaller = 1;
  int workers = 32, rounds = 5;
  double seconds = 0.5;
  bool quick = false, floors = false;
};

/// What is measured of a server with one kind of request.
struct Cell {
  std::string server;
  std::size_t rays = 0;  ///< of each request; 0: the trivial handler
  Form form = Form::kRows;
  int connections = 1;
  std::vector<double> per_second{}, cpu_ns{};  ///< rays (or requests); for each of them
  std::uint64_t failed = 0;
};

/// The same batch without a server.
struct Alone {
  std::size_t rays = 0;
  Form form = Form::kRows;
  std::vector<double> decode{}, trace{}, encode{}, sum{};
};

template <class Value>
Value must(Result<Value> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

/// A third each of camera rays, LiDAR and incoherent rays, a stretch of neighbours from each.
RayBatch ordinary_rays(const BenchScene& scene, std::size_t count) {
  RayBatch rays;
  const auto sets = make_ray_sets(scene, RayCounts::full());
  const std::size_t kinds[] = {0, 1, 3};
  for (std::size_t k = 0; k < 3; ++k) {
    const RayBatch& from = sets[kinds[k]].rays;
    const std::size_t some = (count + k) / 3;
    for (std::size_t i = 0; i < some; ++i) {
      Ray ray = from[(from.size() / 2 + i) % from.size()];
      ray.tmax = Ray().tmax;
      rays.push_back(ray);
    }
  }
  return rays;
}

class Bench {
 public:
  Bench(const Options& options, ServerProcess sightline, ServerProcess embree)
      : options_(options),
        sightline_(std::move(sightline)),
        embree_(std::move(embree)),
        scene_(must(load_bench_scene(options.scene, options.smaller))),
        engine_(must(Engine::create({1, ""}))) {
    make_cells();
  }

  void check_answers();
  void measure();
  int report() const;

 private:
  void make_cells();
  void add(const std::string& server, std::size_t rays, Form form, int connections) {
    cells_.push_back({server, rays, form, connections});
    if (rays == 0 || requests_.contains({rays, form})) return;
    requests_[{rays, form}] = request_of(body_of(ordinary_rays(scene_, rays), form), form);
    alone_.push_back({rays, form});
  }
  std::string body_of_request(std::size_t rays, Form form) const {
    const std::string& request = requests_.at({rays, form});
    return request.substr(request.find("\r\n\r\n") + 4);
  }
  const Cell& cell(const std::string& server, std::size_t rays, Form form, int connections) const;
  const Alone& alone(std::size_t rays, Form form) const;
  std::string ask(const ServerProcess& server, std::size_t rays, Form form) const;
  double floor(const char* what, const std::vector<double>& above, const std::vector<double>& below,
               double bound, bool at_most, Json& document) const;
  Json tables() const;

  const Options& options_;
  ServerProcess sightline_, embree_;
  const BenchScene scene_;
  const std::unique_ptr<Engine> engine_;
  std::map<std::pair<std::size_t, Form>, std::string> requests_;
  std::vector<Cell> cells_;
  std::vector<Alone> alone_;
};

constexpr std::size_t kBatch = 10'000, kHuge = 1'000'000;
/// Enough to keep both sides busy, and few enough that bodies of that size have room at once.
constexpr int kFew = 8, kMany = 64;

void Bench::make_cells() {
  add("healthz", 0, Form::kRows, kMany);
  add("sightline", 1, Form::kRows, kMany);
  for (const Form form : {Form::kRows, Form::kColumns, Form::kBinary}) {
    add("sightline", kBatch, form, kFew);
    if (form != Form::kBinary) add("embree", kBatch, form, kFew);
  }
  if (options_.floors) return;
  const auto is_there = [&](const std::string& server, std::size_t rays, Form form, int count) {
    return std::any_of(cells_.begin(), cells_.end(), [&](const Cell& each) {
      return each.server == server && each.rays == rays && each.form == form &&
             each.connections == count;
    });
  };
  for (const std::size_t rays : {std::size_t{1}, std::size_t{100}, kBatch, kHuge}) {
    if (options_.quick && rays == kHuge) continue;
    for (const Form form : kForms) {
      for (const int count : {1, kFew, kMany}) {
        // Streams are 8 at once, and a million rays are more than the memory for many of them.
        if ((form == Form::kLines && count > kFew) || (rays == kHuge && count > 1)) continue;
        if (rays == kBatch && count == kMany) continue;
        if (!is_there("sightline", rays, form, count)) add("sightline", rays, form, count);
        const bool is_json = form == Form::kRows || form == Form::kColumns;
        if (is_json && count == kFew && !is_there("embree", rays, form, count)) {
          add("embree", rays, form, count);
        }
      }
    }
  }
}

const Cell& Bench::cell(const std::string& server, std::size_t rays, Form form,
                        int connections) const {
  return *std::find_if(cells_.begin(), cells_.end(), [&](const Cell& each) {
    return each.server == server && each.rays == rays && each.form == form &&
           each.connections == connections;
  });
}

const Alone& Bench::alone(std::size_t rays, Form form) const {
  return *std::find_if(alone_.begin(), alone_.end(),
                       [&](const Alone& each) { return each.rays == rays && each.form == form; });
}

std::string Bench::ask(const ServerProcess& server, std::size_t rays, Form form) const {
  httplib::Client client("127.0.0.1", server.port());
  client.set_read_timeout(120);
  const std::string request = requests_.at({rays, form});
  const std::size_t at = request.find("Content-Type: ") + 14;
  const auto answer = client.Post("/v1/scenes/bench/rays:closest", body_of_request(rays, form),
                                  request.substr(at, request.find('\r', at) - at));
  if (!answer || answer->status != 200) {
    const std::string name = &server == &embree_ ? "embree" : "sightline";
    throw std::runtime_error(name + " does not answer " + std::to_string(rays) + " rays as " +
                             std::string(form_name(form)) + ": " +
                             (answer ? answer->body : httplib::to_string(answer.error())));
  }
  return answer->body;
}

/// First the same answers: Sightline's byte for byte, Embree's as often as float32 sees the same.
void Bench::check_answers() {
  for (const auto& [key, request] : requests_) {
    const auto [rays, form] = key;
    // This client sends all before it reads, and so much is answered meanwhile.
    if (form == Form::kLines && rays > kBatch) continue;
    std::string answer;
    measure_alone(*engine_, *scene_.scene, body_of_request(rays, form), form, 0, answer);
    if (ask(sightline_, rays, form) != answer) throw std::runtime_error("answers differ");
  }
  const Json ours = Json::parse(ask(sightline_, kBatch, Form::kColumns));
  const Json theirs = Json::parse(ask(embree_, kBatch, Form::kColumns));
  std::size_t same = 0, hits = 0;
  for (std::size_t i = 0; i < kBatch; ++i) {
    if (ours["triangle"][i] == theirs["triangle"][i]) ++same;
    if (!ours["t"][i].is_null()) ++hits;
  }
  std::printf("%zu of %zu rays hit; Embree names the same triangle for %zu\n", hits, kBatch, same);
  if (same < kBatch * 99 / 100) throw std::runtime_error("Embree was asked something else");
}

void Bench::measure() {
  const std::string trivial = "GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
  for (int round = 0; round < options_.rounds; ++round) {
    for (Cell& each : cells_) {
      const ServerProcess& server = each.server == "embree" ? embree_ : sightline_;
      const std::string& request = each.rays == 0 ? trivial : requests_.at({each.rays, each.form});
      const double before = server.cpu_us();
      const LoadResult load = put_load(server.port(), each.connections, request, options_.seconds);
      const double used = server.cpu_us() - before;
      const double rays = static_cast<double>(load.answers) *
                          static_cast<double>(std::max<std::size_t>(each.rays, 1));
      each.per_second.push_back(rays / load.seconds);
      each.cpu_ns.push_back(used * 1e3 / rays);
      each.failed += load.failed;
    }
    for (Alone& each : alone_) {
      std::string answer;
      const AloneTimes times =
          measure_alone(*engine_, *scene_.scene, body_of_request(each.rays, each.form), each.form,
                        options_.seconds / 4, answer);
      each.decode.push_back(times.decode);
      each.trace.push_back(times.trace);
      each.encode.push_back(times.encode);
      each.sum.push_back(times.sum());
    }
  }
}

Json spread_json(const std::vector<double>& values) {
  const Spread spread = spread_of(values);
  return {spread.median, spread.least, spread.most};
}

Json Bench::tables() const {
  Json document{{"machine", machine_name()},   {"scene", options_.scene},
                {"workers", options_.workers}, {"rounds", options_.rounds},
                {"seconds", options_.seconds}, {"cells", Json::array()},
                {"alone", Json::array()}};
  std::printf("%-10s %8s %-13s %6s %14s %14s %7s\n", "server", "rays", "form", "conns", "rays/s",
              "CPU ns/ray", "failed");
  for (const Cell& each : cells_) {
    std::printf("%-10s %8zu %-13s %6d %14.0f %14.1f %7llu\n", each.server.c_str(), each.rays,
                std::string(form_name(each.form)).c_str(), each.connections,
                spread_of(each.per_second).median, spread_of(each.cpu_ns).median,
                static_cast<unsigned long long>(each.failed));
    document["cells"].push_back({{"server", each.server},
                                 {"rays", each.rays},
                                 {"form", form_name(each.form)},
                                 {"connections", each.connections},
                                 {"per_second", spread_json(each.per_second)},
                                 {"cpu_ns", spread_json(each.cpu_ns)},
                                 {"failed", each.failed}});
  }
  std::printf("%-10s %8s %-13s %10s %10s %10s  ns/ray\n", "alone", "rays", "form", "decode",
              "trace", "encode");
  for (const Alone& each : alone_) {
    std::printf("%-10s %8zu %-13s %10.1f %10.1f %10.1f\n", "", each.rays,
                std::string(form_name(each.form)).c_str(), spread_of(each.decode).median,
                spread_of(each.trace).median, spread_of(each.encode).median);
    document["alone"].push_back({{"rays", each.rays},
                                 {"form", form_name(each.form)},
                                 {"decode_ns", spread_json(each.decode)},
                                 {"trace_ns", spread_json(each.trace)},
                                 {"encode_ns", spread_json(each.encode)},
                                 {"sum_ns", spread_json(each.sum)}});
  }
  return document;
}

/// Prints the median of the quotients of rounds that ran beside each other.
double Bench::floor(const char* what, const std::vector<double>& above,
                    const std::vector<double>& below, double bound, bool at_most,
                    Json& document) const {
  std::vector<double> quotients;
  for (std::size_t i = 0; i < above.size(); ++i) quotients.push_back(above[i] / below[i]);
  const Spread spread = spread_of(quotients);
  const bool good = at_most ? spread.median <= bound : spread.median >= bound;
  std::printf("floor %s %.2f, %.2f to %.2f (needs %s %.1f) %s\n", what, spread.median, spread.least,
              spread.most, at_most ? "at most" : "at least", bound, good ? "ok" : "short");
  document["floors"].push_back(
      {{"what", what}, {"figure", spread_json(quotients)}, {"needs", bound}});
  return spread.median;
}

int Bench::report() const {
  Json document = tables();
  const auto mine = [&](Form form) { return cell("sightline", kBatch, form, kFew); };
  floor("3: JSON columns, CPU of the server to decode + trace + encode alone",
        mine(Form::kColumns).cpu_ns, alone(kBatch, Form::kColumns).sum, 1.8, true, document);
  floor("3: binary, CPU of the server to the trace alone", mine(Form::kBinary).cpu_ns,
        alone(kBatch, Form::kBinary).trace, 1.5, true, document);
  floor("3: one ray as JSON, CPU of the server to the trivial handler",
        cell("sightline", 1, Form::kRows, kMany).cpu_ns,
        cell("healthz", 0, Form::kRows, kMany).cpu_ns, 1.4, true, document);
  for (const Form form : {Form::kColumns, Form::kRows}) {
    const std::string what = "4: " + std::string(form_name(form)) + ", rays per second to Embree";
    floor(what.c_str(), mine(form).per_second, cell("embree", kBatch, form, kFew).per_second, 6,
          false, document);
  }
  std::ofstream(options_.out + "/http.json") << document.dump(2) << "\n";
  return 0;
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Rays over HTTP, beside the codec alone, the trivial handler, and Embree.");
  app.add_option("--out", options.out, "folder for http.json")->capture_default_str();
  app.add_option("--binary", options.binary, "sightline")->capture_default_str();
  app.add_option("--scene", options.scene)->capture_default_str();
  app.add_option("--smaller", options.smaller, "divides generated triangle counts");
  app.add_option("--workers", options.workers)->capture_default_str();
  app.add_option("--rounds", options.rounds)->capture_default_str();
  app.add_option("--seconds", options.seconds, "of each cell in each round")->capture_default_str();
  app.add_flag("--quick", options.quick, "3 rounds, no requests of a million rays");
  app.add_flag("--floors", options.floors, "only the cells of the floors");
  CLI11_PARSE(app, argc, argv);
  if (options.quick) options.rounds = 3;
  options.out = std::filesystem::absolute(options.out).string();
  std::filesystem::create_directories(options.out);
  const auto file = must(bench_scene_file(options.scene, options.smaller, options.out));
  // Before there are threads here.
  ServerProcess embree = ServerProcess::own([&](int port) {
    serve_embree(*must(load_bench_scene(options.scene, options.smaller)).scene, options.workers,
                 port);
  });
  ServerProcess sightline = ServerProcess::sightline(
      options.binary, options.workers, {"--preload", "bench=" + file.string(), "--skip", "none"});
  Bench bench(options, std::move(sightline), std::move(embree));
  bench.check_answers();
  bench.measure();
  return bench.report();
}

}  // namespace
}  // namespace sightline::bench

int main(int argc, char** argv) {
  try {
    return sightline::bench::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "http_bench: " << error.what() << "\n";
    return 1;
  }
}
