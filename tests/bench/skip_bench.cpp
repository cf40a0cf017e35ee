// What skipping saves: files become scenes and answer rays, lazily and with nothing skipped.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "tests/bench/machine.h"
#include "tests/bench/skip_runs.h"
#include "tests/support/data_folder.h"

namespace sightline::bench {
namespace {

using Json = nlohmann::json;

Json apart(const std::function<Json()>& work) {
  const std::string text = in_own_process([&] { return work().dump(); });
  return text.empty() ? Json{{"error", "the process ended early"}} : Json::parse(text);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[values.size() / 2];
}

double figure(const std::vector<Json>& runs, const char* name) {
  std::vector<double> values;
  values.reserve(runs.size());
  for (const Json& run : runs) values.push_back(run.at(name).get<double>());
  return median(values);
}

/// One file, lazily and not, turn about.
Json compare(const std::string& name, const std::filesystem::path& file, int repetitions) {
  std::vector<Json> lazy, none;
  for (int i = 0; i < repetitions; ++i) {
    lazy.push_back(apart([&] { return run_rays(file, true); }));
    none.push_back(apart([&] { return run_rays(file, false); }));
    for (const Json* run : {&lazy.back(), &none.back()}) {
      if (run->contains("error")) return {{"scene", name}, {"error", run->at("error")}};
    }
  }
  const bool identical = std::all_of(none.begin(), none.end(), [&](const Json& run) {
    return run.at("hash") == lazy[0].at("hash");
  });
  Json row = {{"scene", name}, {"identical", identical}, {"meshes_total", lazy[0]["meshes_total"]}};
  row["triangles"] = lazy[0]["triangles"];
  row["built"] = lazy[0]["built"];
  row["file_bytes"] = lazy[0]["file_bytes"];
  for (const auto& [twin, runs] : {std::pair{"lazy", &lazy}, std::pair{"none", &none}}) {
    for (const char* what :
         {"import_seconds", "first_answer_seconds", "build_seconds", "peak_mib", "bytes_touched",
          "nodes_per_ray", "blocks_per_ray", "bytes_out_per_ray"}) {
      row[twin][what] = figure(*runs, what);
    }
  }
  const double sooner = row["none"]["first_answer_seconds"].get<double>() /
                        row["lazy"]["first_answer_seconds"].get<double>();
  row["sooner"] = sooner;
  std::printf(
      "%-22s first answer %8.3f s, with nothing skipped %8.3f s (%.1f times sooner), meshes "
      "built %llu, %llu, %llu of %llu, answers identical: %s\n",
      name.c_str(), row["lazy"]["first_answer_seconds"].get<double>(),
      row["none"]["first_answer_seconds"].get<double>(), sooner,
      row["built"][0]["meshes"].get<unsigned long long>(),
      row["built"][1]["meshes"].get<unsigned long long>(),
      row["built"][2]["meshes"].get<unsigned long long>(),
      row["meshes_total"].get<unsigned long long>(), identical ? "yes" : "no");
  std::fflush(stdout);
  return row;
}

/// The large file beside Embree, and after a restart.
Json large(const std::filesystem::path& file, const std::filesystem::path& folder,
           int repetitions) {
  std::vector<Json> fresh, again, embree;
  for (int i = 0; i < repetitions; ++i) {
    std::filesystem::remove_all(folder);
    embree.push_back(apart([&] { return run_embree(file); }));
    fresh.push_back(apart([&] { return run_server(file, folder); }));
    again.push_back(apart([&] { return run_server(file, folder); }));
    for (const Json* run : {&embree.back(), &fresh.back(), &again.back()}) {
      if (run->contains("error")) return *run;
    }
  }
  std::filesystem::remove_all(folder);
  Json row;
  row["embree"] = {{"read_seconds", figure(embree, "read_seconds")},
                   {"build_seconds", figure(embree, "build_seconds")}};
  for (const auto& [name, runs] : {std::pair{"fresh", &fresh}, std::pair{"restart", &again}}) {
    for (const char* what : {"first_answer_seconds", "settled_seconds", "full_builds", "cache_hits",
                             "tree_mib", "geometry_mib", "peak_mib", "final_mib"}) {
      row[name][what] = figure(*runs, what);
    }
  }
  row["identical"] = fresh[0]["hash"] == again[0]["hash"];
  return row;
}

std::string line(int floor, double value, const char* needs, bool ok, const char* what) {
  char text[240];
  std::snprintf(text, sizeof text, "floor %d: %.3g (needs %s) %s  %s", floor, value, needs,
                ok ? "ok" : "short", what);
  return text;
}

std::vector<std::string> floors(const Json& report) {
  std::vector<std::string> lines;
  const auto& rows = report.at("scenes");
  const bool identical = std::all_of(rows.begin(), rows.end(),
                                     [](const Json& row) { return row.value("identical", false); });
  for (const Json& row : rows) {
    if (row.at("scene") != "distinct_10k" || row.contains("error")) continue;
    const double trees = row["built"][0]["trees"].get<double>();
    const double sooner = row["sooner"].get<double>();
    lines.push_back(
        line(4, trees, "1", trees == 1, "trees built for one ray into 10,000 distinct meshes"));
    lines.push_back(line(4, sooner, "at least 10", sooner >= 10,
                         "times sooner the first answer comes than with nothing skipped"));
  }
  lines.push_back(line(4, identical ? 1 : 0, "1", identical, "answers identical in every scene"));
  if (!report.contains("large") || report["large"].contains("error")) return lines;
  const Json& big = report["large"];
  const double reference =
      big["embree"]["read_seconds"].get<double>() + big["embree"]["build_seconds"].get<double>();
  const double first = big["fresh"]["first_answer_seconds"].get<double>() / reference;
  const double memory =
      big["fresh"]["peak_mib"].get<double>() / big["fresh"]["final_mib"].get<double>();
  double build = 0;
  for (const Json& row : rows) {
    if (row.at("scene") == "terrain_10M") build = row["none"]["build_seconds"].get<double>();
  }
  const double restart = build / big["restart"]["first_answer_seconds"].get<double>();
  const bool cached = big["restart"]["cache_hits"].get<double>() == 1;
  lines.push_back(line(5, first, "at most 1.5", first <= 1.5,
                       "first answer of 10 M triangles against reading them and Embree medium"));
  lines.push_back(line(5, memory, "at most 2.0", memory <= 2,
                       "peak of memory against what is left, 10 M triangles, all trees built"));
  lines.push_back(line(5, restart, "at least 20", restart >= 20 && cached,
                       "times sooner the first answer comes after a restart than the build took"));
  return lines;
}

bool write_report(Json report, const std::string& folder) {
  report["floors"] = floors(report);
  std::ofstream markdown(folder + "/skip.md");
  markdown << "# Skipping: lazily beside nothing skipped\n\n"
           << machine_name() << ", medians of " << report["repetitions"].get<int>()
           << " runs, each in a process of its own; two threads, files in the page cache.\n\n";
  for (const auto& floor : report["floors"]) markdown << "- " << floor.get<std::string>() << '\n';
  markdown
      << "\n| scene | triangles | bytes read / in file | first answer, s | nothing skipped, s | "
         "peak, MiB | nothing skipped, MiB | meshes built after 1, 100, 10,000 rays | of | "
         "nodes per ray | nothing skipped | blocks per ray | nothing skipped | bytes out per ray, "
         "t "
         "alone | all of a hit's geometry | answers identical |\n"
         "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|---|\n";
  for (const Json& row : report["scenes"]) {
    char text[600];
    if (row.contains("error")) {
      markdown << "| " << row["scene"].get<std::string>() << " | "
               << row["error"].get<std::string>() << " |\n";
      continue;
    }
    std::snprintf(
        text, sizeof text,
        "| %s | %llu | %.2f | %.4f | %.4f | %.0f | %.0f | %llu, %llu, %llu | %llu | %.1f | %.1f | "
        "%.1f | %.1f | %.0f | %.0f | %s |\n",
        row["scene"].get<std::string>().c_str(), row["triangles"].get<unsigned long long>(),
        row["lazy"]["bytes_touched"].get<double>() / row["file_bytes"].get<double>(),
        row["lazy"]["first_answer_seconds"].get<double>(),
        row["none"]["first_answer_seconds"].get<double>(), row["lazy"]["peak_mib"].get<double>(),
        row["none"]["peak_mib"].get<double>(), row["built"][0]["meshes"].get<unsigned long long>(),
        row["built"][1]["meshes"].get<unsigned long long>(),
        row["built"][2]["meshes"].get<unsigned long long>(),
        row["meshes_total"].get<unsigned long long>(), row["lazy"]["nodes_per_ray"].get<double>(),
        row["none"]["nodes_per_ray"].get<double>(), row["lazy"]["blocks_per_ray"].get<double>(),
        row["none"]["blocks_per_ray"].get<double>(), row["lazy"]["bytes_out_per_ray"].get<double>(),
        row["none"]["bytes_out_per_ray"].get<double>(),
        row["identical"].get<bool>() ? "yes" : "no");
    markdown << text;
  }
  std::ofstream out(folder + "/skip.json");
  out << report.dump(1) << '\n';
  return out.good() && markdown.good();
}

}  // namespace
}  // namespace sightline::bench

int main(int argc, char** argv) {
  using namespace sightline::bench;
  std::vector<std::string> wishes;
  std::string out = ".";
  int repetitions = 0;
  bool quick = false;
  CLI::App app("Lazily beside nothing skipped.");
  app.add_option("--scene", wishes, "names of files without their ending; default: all")
      ->delimiter(',');
  app.add_option("--repetitions", repetitions, "default 3, quick 1");
  app.add_option("--out", out, "write skip.json and skip.md to this folder, and generated files");
  app.add_flag("--quick", quick, "generated files with a tenth of their triangles, one repetition");
  CLI11_PARSE(app, argc, argv);
  if (repetitions <= 0) repetitions = quick ? 1 : 3;
  const auto wanted = [&](const std::string& name) {
    return wishes.empty() || std::find(wishes.begin(), wishes.end(), name) != wishes.end();
  };

  const std::filesystem::path folder(out);
  const std::filesystem::path made = folder / (quick ? "skip_quick" : "skip");
  std::filesystem::create_directories(made);
  std::vector<std::pair<std::string, std::filesystem::path>> files;
  for (const std::string name : {"distinct_10k", "terrain_10M"}) {
    if (!wanted(name)) continue;
    files.emplace_back(name, made / (name + ".glb"));
    if (apart([&] {
          return Json{{"made", make_file(files.back().second, quick ? 10 : 1)}};
        }) != Json{{"made", true}}) {
      std::fprintf(stderr, "skip_bench: %s could not be made\n", name.c_str());
      return 1;
    }
  }
  std::vector<std::filesystem::path> stored;
  if (const auto data = sightline::test::data_folder()) {
    for (const auto& entry : std::filesystem::directory_iterator(*data / "scenes")) {
      const auto ending = entry.path().extension();
      if (ending == ".glb" || ending == ".gltf") stored.push_back(entry.path());
    }
  }
  std::sort(stored.begin(), stored.end());
  for (const auto& file : stored) {
    if (wanted(file.stem().string())) files.emplace_back(file.stem().string(), file);
  }

  Json report = {{"benchmark", "skip"}, {"machine", machine_name()}, {"repetitions", repetitions}};
  for (const auto& [name, file] : files) {
    if (!settle_file(file)) {
      std::fprintf(stderr, "skip_bench: %s cannot be read\n", file.c_str());
      return 1;
    }
    report["scenes"].push_back(compare(name, file, repetitions));
    if (report["scenes"].back().contains("error")) {
      std::fprintf(stderr, "skip_bench: %s: %s\n", name.c_str(),
                   report["scenes"].back()["error"].get<std::string>().c_str());
      return 1;
    }
    if (name == "terrain_10M") {
      report["large"] = large(file, made / "trees", repetitions);
      std::printf("%s\n", report["large"].dump().c_str());
    }
  }
  for (const std::string& floor : floors(report)) std::printf("%s\n", floor.c_str());
  return write_report(report, out) ? 0 : 1;
}
