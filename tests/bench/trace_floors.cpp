#include <algorithm>
#include <cstdio>
#include <functional>

#include "tests/bench/trace_result.h"

namespace sightline::bench {

namespace {

const std::vector<std::string> kMeanScenes = {"terrain", "scan", "soup", "city"};

bool is_mean_scene(const TraceCell& cell) {
  return std::find(kMeanScenes.begin(), kMeanScenes.end(), cell.scene) != kMeanScenes.end();
}

struct Figure {
  std::vector<double> ratios;
  std::string where_least;
  double least = 0;
};

bool is_generated(const TraceCell& cell) {
  return is_mean_scene(cell) || cell.scene == "instances";
}

/// Speed of `ours` against `theirs(cell)` in the cells that pass; empty when something is missing.
Figure ratios(const TraceResult& result, const std::string& ours,
              const std::function<bool(const TraceCell&)>& pass,
              const std::function<double(const TraceCell&)>& theirs) {
  Figure figure;
  for (const TraceCell& cell : result.cells) {
    if (!pass(cell) || !cell.has(ours)) continue;
    const double time = theirs(cell);
    if (!(time > 0)) continue;
    figure.ratios.push_back(time / cell.median(ours));
    if (figure.ratios.size() == 1 || figure.ratios.back() < figure.least) {
      figure.least = figure.ratios.back();
      figure.where_least = cell.scene + " " + cell.rays + " " + cell.query;
    }
  }
  return figure;
}

std::string line(int floor, double figure, double needs, bool measured, const std::string& what) {
  char text[320];
  if (!measured) {
    std::snprintf(text, sizeof text, "floor %d: not measured (needs %.2f) short  %s", floor, needs,
                  what.c_str());
  } else {
    std::snprintf(text, sizeof text, "floor %d: %.2f (needs %.2f) %s  %s", floor, figure, needs,
                  figure >= needs ? "ok" : "short", what.c_str());
  }
  return text;
}

std::string mean_line(int floor, const Figure& figure, double needs, const std::string& what) {
  return line(floor, geometric_mean(figure.ratios), needs, !figure.ratios.empty(),
              what + ", mean of " + std::to_string(figure.ratios.size()) + " cells");
}

std::string least_line(int floor, const Figure& figure, double needs, const std::string& what) {
  return line(floor, figure.least, needs, !figure.ratios.empty(),
              what + ", least: " + figure.where_least);
}

std::function<double(const TraceCell&)> time_of(const std::string& name) {
  return [name](const TraceCell& cell) { return cell.has(name) ? cell.median(name) : 0; };
}

/// The least median of Embree's entries; of robust ones only, if asked.
std::function<double(const TraceCell&)> best_embree(bool robust) {
  return [robust](const TraceCell& cell) {
    double best = 0;
    for (const auto& [name, times] : cell.times) {
      if (!name.starts_with("embree") || (robust && !name.ends_with("_robust"))) continue;
      const double time = spread_of(times).median;
      if (best == 0 || time < best) best = time;
    }
    return best;
  };
}

}  // namespace

std::vector<std::string> trace_floors(const TraceResult& result) {
  const auto closest = [](const TraceCell& c) { return c.query == "closest"; };
  const auto any = [](const TraceCell& c) { return c.query == "any"; };
  const auto mean_closest = [&](const TraceCell& c) { return closest(c) && is_mean_scene(c); };
  const auto mean_any = [&](const TraceCell& c) { return any(c) && is_mean_scene(c); };
  const auto packet_land = [](const TraceCell& c) {
    return c.scene == "city" && (c.rays == "camera" || c.rays == "lidar");
  };
  const auto embree1 = time_of("embree1");

  std::vector<std::string> lines;
  lines.push_back(mean_line(1, ratios(result, "sightline", mean_closest, embree1), 1.4,
                            "batches of 262,144, closest, against embree1"));
  lines.push_back(mean_line(1,
                            ratios(
                                result, "sightline",
                                [&](const TraceCell& c) {
                                  return mean_closest(c) &&
                                         (c.rays == "ao" || c.rays == "incoherent");
                                },
                                best_embree(false)),
                            1.2, "ao and incoherent, against Embree's best entry"));
  const auto against_robust = [&](const auto& pass, double needs, const std::string& what) {
    const auto cells = [&](const TraceCell& c) { return closest(c) && pass(c); };
    lines.push_back(least_line(2, ratios(result, "sightline", cells, best_embree(true)), needs,
                               what + ", closest, against Embree's best robust entry"));
  };
  against_robust([&](const TraceCell& c) { return is_generated(c) && !packet_land(c); }, 0.9,
                 "every cell of the generated scenes and the scan");
  against_robust(packet_land, 0.7, "city camera and lidar");
  against_robust([](const TraceCell& c) { return !is_generated(c); }, 0.9,
                 "every cell of the other files");
  lines.push_back(mean_line(3, ratios(result, "sightline", mean_any, embree1), 1.4,
                            "batches of 262,144, any, against embree1"));
  lines.push_back(mean_line(3, ratios(result, "sightline_64", mean_closest, embree1), 1.3,
                            "batches of 64, closest, against embree1"));
  lines.push_back(least_line(3, ratios(result, "sightline", any, embree1), 0.95,
                             "any, every cell, against embree1"));
  lines.push_back(least_line(3, ratios(result, "sightline_64", closest, embree1), 0.95,
                             "batches of 64, every cell, against embree1"));
  lines.push_back(mean_line(4, ratios(result, "sightline_1", mean_closest, time_of("embree1_avx2")),
                            0.75, "single rays, closest, against embree1_avx2"));
  lines.push_back(mean_line(
      5,
      ratios(
          result, "sightline",
          [&](const TraceCell& c) { return closest(c) && c.scene == "instances"; }, embree1),
      1.2, "instances, closest, against embree1"));

  for (const char* query : {"closest", "any"}) {
    const auto mean_cells = [&](const TraceCell& c) {
      return c.query == query && is_mean_scene(c);
    };
    lines.push_back(
        mean_line(9, ratios(result, "sightline_keep_all", mean_cells, time_of("sightline")), 0.9,
                  std::string(query) + ", a filter that keeps everything, against no filter"));
    lines.push_back(
        mean_line(9, ratios(result, "sightline_keep_fronts", mean_cells, time_of("sightline")), 0.7,
                  std::string(query) + ", a filter that keeps fronts, against no filter"));
  }

  std::size_t wrong = 0, judged = 0;
  for (const auto& [name, check] : result.checks) {
    wrong += check.sightline_wrong + check.inconsistent;
    judged += check.judged;
  }
  char text[160];
  std::snprintf(text, sizeof text,
                "floor 8: %zu (needs 0) %s  wrong answers of Sightline; %zu rays judged", wrong,
                wrong == 0 && judged > 0 ? "ok" : "short", judged);
  lines.emplace_back(text);
  return lines;
}

}  // namespace sightline::bench
