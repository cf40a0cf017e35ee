#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/bench/accuracy_result.h"

namespace sightline::bench {

namespace {

using Json = nlohmann::ordered_json;

std::string format(const char* how, double value) {
  char text[64];
  std::snprintf(text, sizeof text, how, value);
  return text;
}

/// Ulps, from exactly 0 to astronomical.
std::string ulps(double value) {
  if (value == 0) return "0";
  return format(value < 1e4 ? "%.2g" : "%.1e", value);
}

std::string share(const AccuracyPoint& point) {
  if (point.wrong == 0) return "0";
  const double percent = 100 * point.wrong_share();
  return format(percent < 0.01 ? "%.1e%%" : "%.2g%%", percent);
}

Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json to_json(const AccuracyPoint& point) {
  return {{"panel", point.panel},
          {"group", point.group},
          {"contestant", point.contestant},
          {"judged", point.judged},
          {"wrong", point.wrong},
          {"ns", point.ns.median},
          {"least", point.ns.least},
          {"most", point.ns.most},
          {"t_median_ulp", finite(point.t_median_ulp)},
          {"t_worst_ulp", finite(point.t_worst_ulp)}};
}

Json to_json(const AccuracyCell& cell) {
  Json entries = Json::object();
  for (const auto& [name, entry] : cell.entries) {
    const Spread error = spread_of(entry.t_errors);
    entries[name] = {{"ns", spread_of(entry.times).median}, {"repetitions", entry.times},
                     {"false_hits", entry.false_hits},      {"false_misses", entry.false_misses},
                     {"wrong_place", entry.wrong_place},    {"t_median_ulp", finite(error.median)},
                     {"t_worst_ulp", finite(error.most)}};
  }
  return {{"panel", cell.panel},
          {"group", cell.group},
          {"family", cell.family},
          {"judged", cell.count},
          {"contestants", std::move(entries)}};
}

Json to_json(const AccuracyResult& result) {
  Json json = {{"benchmark", "accuracy"},
               {"machine", result.machine},
               {"kernel", result.kernel},
               {"cpu", result.cpu},
               {"quick", result.quick},
               {"repetitions", result.repetitions},
               {"seed", std::to_string(result.seed)},
               {"scene", result.scene},
               {"triangles", result.triangles}};
  for (const AccuracyPoint& point : accuracy_points(result)) {
    json["points"].push_back(to_json(point));
  }
  for (const AccuracyCell& cell : result.cells) json["cells"].push_back(to_json(cell));
  json["floors"] = accuracy_floors(result);
  return json;
}

void write_csv(const AccuracyResult& result, std::ostream& out) {
  out << "panel,group,family,judged,contestant,ns,least,most,false_hits,false_misses,wrong_place,"
         "t_median_ulp,t_worst_ulp\n";
  for (const AccuracyCell& cell : result.cells) {
    for (const std::string& name : result.contestants.at(cell.panel)) {
      const AccuracyEntry& entry = cell.entries.at(name);
      const Spread time = spread_of(entry.times), error = spread_of(entry.t_errors);
      out << cell.panel << ',' << cell.group << ',' << cell.family << ',' << cell.count << ','
          << name << ',' << time.median << ',' << time.least << ',' << time.most << ','
          << entry.false_hits << ',' << entry.false_misses << ',' << entry.wrong_place << ','
          << error.median << ',' << error.most << '\n';
    }
  }
}

/// What the picture shows.
void write_points(const AccuracyResult& result, const std::string& panel, std::ostream& out) {
  out << "\n| rays | contestant | ns (least to most) | judged | wrong | share | t, median ulp | t, "
         "worst ulp |\n|---|---|--:|--:|--:|--:|--:|--:|\n";
  for (const AccuracyPoint& p : accuracy_points(result)) {
    if (p.panel != panel) continue;
    out << "| " << p.group << " | " << p.contestant << " | " << format("%.1f", p.ns.median) << " ("
        << format("%.1f", p.ns.least) << " to " << format("%.1f", p.ns.most) << ") | " << p.judged
        << " | " << p.wrong << " | " << share(p) << " | " << ulps(p.t_median_ulp) << " | "
        << ulps(p.t_worst_ulp) << " |\n";
  }
}

void write_families(const AccuracyResult& result, const std::string& panel, std::ostream& out) {
  const std::vector<std::string>& names = result.contestants.at(panel);
  out << "\nNanoseconds: false hits/false misses" << (panel == "scene" ? "/wrong triangle" : "")
      << "\n\n| rays | judged |";
  for (const std::string& name : names) out << ' ' << name << " |";
  out << "\n|---|--:|";
  for (std::size_t i = 0; i < names.size(); ++i) out << "--:|";
  out << '\n';
  for (const AccuracyCell& cell : result.cells) {
    if (cell.panel != panel) continue;
    out << "| " << cell.group << ": " << cell.family << " | " << cell.count << " |";
    for (const std::string& name : names) {
      const AccuracyEntry& entry = cell.entries.at(name);
      out << ' ' << format("%.1f", spread_of(entry.times).median) << ": ";
      if (entry.wrong() == 0) {
        out << "0 |";
        continue;
      }
      out << entry.false_hits << '/' << entry.false_misses;
      if (panel == "scene") out << '/' << entry.wrong_place;
      out << " |";
    }
    out << '\n';
  }
}

/// The results of rays and a scene.
void write_scene_panel(const AccuracyResult& result, std::ostream& out) {
  out << "\n## Rays and a scene of " << result.triangles << " triangles (" << result.scene
      << ")\n\nThe textbook tests run on Sightline's own tree and traversal: what differs is the "
         "triangle test and what it needs. `sightline_unrounded` is Sightline without the final "
         "rounding: its kernel and its decisions, but t as n.(v0 - o) / n.d in float64. `ordinary` "
         "and `hard_float32` rays are float32 numbers, the same for all; `hard_float64` rays are "
         "rounded by who computes in float32. The `far` groups, with origins 1e5 to 1e8 scene "
         "sizes away, are not in the picture: float32 boxes let such rays into most of the tree, "
         "which takes a thousand times as long.\n";
  write_points(result, "scene", out);
  write_families(result, "scene", out);
}

/// The results of rays and boxes.
void write_box_panel(const AccuracyResult& result, std::ostream& out) {
  out << "\n## Rays and boxes\n\nOne pair at a time, in float64. Sightline's answer has entry, "
         "exit, t, faces and the slabs that exclude a miss, all of them judged; the others say hit "
         "and t, and their t is taken for the entry, the exit or the lower limit, whatever it is "
         "nearest to. `ize2013_padded` means to err on the side of false hits. `fma_inverse` calls "
         "the C library, since these tests are compiled for any x86-64.\n";
  write_points(result, "box", out);
  write_families(result, "box", out);
}

void write_markdown(const AccuracyResult& result, std::ostream& out) {
  out << "# Accuracy: run time against error\n\nMade by `scripts/bench.sh accuracy"
      << (result.quick ? " --quick" : "") << "`.\n\n![Run time against error](accuracy.svg)\n\n"
      << result.machine << "; one thread pinned to CPU " << result.cpu << ", its own CPU time, "
      << "medians of " << result.repetitions << " interleaved repetitions"
      << (result.quick ? " (quick)" : "") << "; kernel " << result.kernel << "; seed "
      << result.seed << ".\n\n";
  for (const std::string& floor : accuracy_floors(result)) out << "- " << floor << '\n';
  out << "\nEvery answer was judged by rational arithmetic. Wrong is a false hit, a false miss, or "
         "a "
         "triangle that is not met at the exact least t; naming another triangle of a tie is not "
         "held against anybody but Sightline, whose t must be right in every bit. The error of t "
         "is in float64 ulp (float32 has steps of 5e8 of them) and of the answers that are not "
         "wrong.\n";
  if (result.contestants.contains("scene")) write_scene_panel(result, out);
  if (result.contestants.contains("box")) write_box_panel(result, out);
}

}  // namespace

bool write_accuracy_report(const AccuracyResult& result, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  std::ofstream json(folder + "/accuracy.json"), csv(folder + "/accuracy.csv"),
      markdown(folder + "/accuracy.md");
  json << to_json(result).dump(1) << '\n';
  write_csv(result, csv);
  write_markdown(result, markdown);
  return json.good() && csv.good() && markdown.good();
}

}  // namespace sightline::bench
