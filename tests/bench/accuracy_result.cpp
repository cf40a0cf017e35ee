#include "tests/bench/accuracy_result.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace sightline::bench {

namespace {

/// Adds what one contestant did in one cell, times weighted by the number of rays.
struct Sum {
  AccuracyPoint point;
  std::vector<double> errors, times;

  void add(const AccuracyEntry& entry, std::size_t count) {
    point.judged += count;
    point.wrong += entry.wrong();
    errors.insert(errors.end(), entry.t_errors.begin(), entry.t_errors.end());
    times.resize(std::max(times.size(), entry.times.size()));
    for (std::size_t i = 0; i < entry.times.size(); ++i) {
      times[i] += entry.times[i] * static_cast<double>(count);
    }
  }

  AccuracyPoint finish() {
    for (double& time : times) time /= static_cast<double>(point.judged);
    point.ns = spread_of(times);
    point.t_median_ulp = spread_of(errors).median;
    point.t_worst_ulp = spread_of(errors).most;
    return point;
  }
};

std::string floor_line(const AccuracyResult& result, const std::string& panel) {
  std::size_t judged = 0, wrong = 0;
  for (const AccuracyCell& cell : result.cells) {
    const auto ours = cell.entries.find(kOurs);
    if (cell.panel != panel || ours == cell.entries.end()) continue;
    judged += cell.count;
    wrong += ours->second.wrong();
  }
  return "floor 7: " + panel + " panel, Sightline wrong " + std::to_string(wrong) + " of " +
         std::to_string(judged) + " judged (needs 0) " +
         (wrong == 0 && judged > 0 ? "ok" : "short");
}

}  // namespace

double ulp_error(double t, double truth) {
  if (t == truth) return 0;
  if (!std::isfinite(t) || !std::isfinite(truth)) return std::numeric_limits<double>::infinity();
  int exponent = 0;
  std::frexp(truth, &exponent);
  return std::fabs(t - truth) / std::ldexp(1.0, std::max(exponent - 53, -1074));
}

std::vector<AccuracyPoint> accuracy_points(const AccuracyResult& result) {
  std::vector<AccuracyPoint> points;
  for (const char* panel : {"scene", "box"}) {
    std::vector<std::string> groups;
    for (const AccuracyCell& cell : result.cells) {
      if (cell.panel == panel &&
          std::find(groups.begin(), groups.end(), cell.group) == groups.end())
        groups.push_back(cell.group);
    }
    const auto names = result.contestants.find(panel);
    if (names == result.contestants.end()) continue;
    for (const std::string& group : groups) {
      for (const std::string& name : names->second) {
        Sum sum;
        sum.point.panel = panel;
        sum.point.group = group;
        sum.point.contestant = name;
        for (const AccuracyCell& cell : result.cells) {
          const auto entry = cell.entries.find(name);
          if (cell.panel == panel && cell.group == group && entry != cell.entries.end())
            sum.add(entry->second, cell.count);
        }
        if (sum.point.judged > 0) points.push_back(sum.finish());
      }
    }
  }
  return points;
}

std::vector<std::string> accuracy_floors(const AccuracyResult& result) {
  std::vector<std::string> lines{floor_line(result, "scene"), floor_line(result, "box")};
  const auto points = accuracy_points(result);
  const auto ns = [&](const char* panel, const char* group, const char* name) -> double {
    for (const AccuracyPoint& p : points) {
      if (p.panel == panel && p.group == group && p.contestant == name) return p.ns.median;
    }
    return 0;
  };
  const auto add = [&](const std::string& text, double figure, double most, const char* unit) {
    if (figure == 0) return;  // a panel that was not run
    char numbers[80];
    std::snprintf(numbers, sizeof numbers, " %.1f%s (needs at most %.0f) ", figure, unit, most);
    lines.push_back("floor 8: " + text + numbers + (figure <= most ? "ok" : "short"));
  };
  add("ordinary pairs, outcome and t", ns("box", "ordinary", kOurs), 12, " ns");
  add("ordinary pairs, all fields", ns("box", "ordinary", kOursAll), 40, " ns");
  add("hard pairs, outcome and t", ns("box", "hard", kOurs), 60, " ns");
  add("hard pairs, all fields", ns("box", "hard", kOursAll), 60, " ns");
  const double ordinary = ns("scene", "ordinary", kOurs);
  for (const char* group : {"hard_float32", "hard_float64"}) {
    if (ordinary > 0)
      add(std::string(group) + " rays, times ordinary ones", ns("scene", group, kOurs) / ordinary,
          5, "");
  }
  return lines;
}

}  // namespace sightline::bench
