#pragma once
/// What one run of the accuracy benchmark measured: run time beside error.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/bench/statistics.h"

namespace sightline::bench {

/// One contestant on one set of rays or pairs.
struct AccuracyEntry {
  std::size_t false_hits = 0;
  std::size_t false_misses = 0;
  std::size_t wrong_place = 0;   ///< of triangles: not the nearest. Sightline: or a bit of t
  std::vector<double> t_errors;  ///< in float64 ulp, where it names the right place
  std::vector<double> times;     ///< nanoseconds each, one per interleaved repetition

  std::size_t wrong() const { return false_hits + false_misses + wrong_place; }
};

/// One set; everything in it was judged.
struct AccuracyCell {
  std::string panel;   ///< "scene" or "box"
  std::string group;   ///< "ordinary", "hard_float32" .. (accuracy_rays.h)
  std::string family;  ///< what the rays aim at
  std::size_t count = 0;
  std::map<std::string, AccuracyEntry> entries;
};

/// One mark of the picture: a contestant on all sets of a group.
struct AccuracyPoint {
  std::string panel, group, contestant;
  std::size_t judged = 0, wrong = 0;
  Spread ns;
  double t_median_ulp = 0, t_worst_ulp = 0;

  double wrong_share() const { return static_cast<double>(wrong) / static_cast<double>(judged); }
};

struct AccuracyResult {
  std::string machine, kernel, scene;
  std::uint64_t seed = 0, triangles = 0;
  int cpu = 0, repetitions = 0;
  bool quick = false;
  std::vector<AccuracyCell> cells;
  /// In the order of the tables, by panel. "sightline" comes first.
  std::map<std::string, std::vector<std::string>> contestants;
};

/// Contestant of the box panel: Sightline in batches, with the outcome and t of each pair.
inline constexpr const char* kOurs = "sightline";
/// Contestants of the box panel: Sightline in batches with every field but the t of planes, and one
/// pair at a time.
inline constexpr const char* kOursAll = "sightline_all_fields";
inline constexpr const char* kOursSingle = "sightline_one_pair";
inline bool is_ours(const std::string& name) {
  return name == kOurs || name == kOursAll || name == kOursSingle;
}

/// |t - truth| in units of the last place of truth, a correctly rounded t. Infinite if only one of
/// them is finite, and for NaN.
double ulp_error(double t, double truth);

std::vector<AccuracyPoint> accuracy_points(const AccuracyResult& result);
/// "floor 7: FIGURE (needs FIGURE) ok|short ...", a line for each panel.
std::vector<std::string> accuracy_floors(const AccuracyResult& result);
/// Writes FOLDER/accuracy.json, accuracy.csv and accuracy.md. False if a file cannot be written.
bool write_accuracy_report(const AccuracyResult& result, const std::string& folder);

}  // namespace sightline::bench
