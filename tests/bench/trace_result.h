#pragma once
/// What one run of the trace benchmark measured.

#include <map>
#include <string>
#include <vector>

#include "tests/bench/answer_check.h"
#include "tests/bench/statistics.h"

namespace sightline::bench {

/// One scene, one set of rays, one query ("closest" or "any").
struct TraceCell {
  std::string scene, rays, query;
  std::size_t count = 0;
  /// Per contestant, in nanoseconds per ray, one entry for each repetition; the repetitions of all
  /// contestants were interleaved.
  std::map<std::string, std::vector<double>> times;

  bool has(const std::string& name) const { return times.contains(name); }
  double median(const std::string& name) const { return spread_of(times.at(name)).median; }
};

struct SceneFacts {
  std::string name;
  std::uint64_t unique_triangles = 0, placed_triangles = 0, instances = 0;
  double build_seconds = 0;
};

struct TraceResult {
  std::string machine, kernel;
  bool quick = false;
  int repetitions = 0, cpu = 0;
  long huge_kib = 0, resident_kib = 0;
  std::vector<std::string> contestants;
  std::vector<SceneFacts> scenes;
  std::vector<TraceCell> cells;
  std::map<std::string, AnswerCheck> checks;  ///< by "scene rays"
  std::map<std::string, std::string> work;    ///< by "scene rays": what Sightline did per ray
};

/// One line per floor of the trace: "floor N: FIGURE (needs FIGURE) ok|short", then what it is of.
/// A floor whose cells were not measured says "not measured".
std::vector<std::string> trace_floors(const TraceResult& result);

/// Writes FOLDER/trace.json, trace.csv and trace.md. False if a file cannot be written.
bool write_trace_report(const TraceResult& result, const std::string& folder);

}  // namespace sightline::bench
