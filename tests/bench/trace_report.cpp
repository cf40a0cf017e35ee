#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/bench/trace_result.h"

namespace sightline::bench {

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const TraceCell& cell) {
  Json contestants = Json::object();
  for (const auto& [name, times] : cell.times) {
    const Spread time = spread_of(times);
    Json entry = {{"ns_per_ray", time.median},
                  {"least", time.least},
                  {"most", time.most},
                  {"repetitions", times}};
    if (cell.has("embree1")) {
      const Spread ratio = speed_ratio(cell.times.at("embree1"), times);
      entry["speed"] = {{"ratio", ratio.median}, {"least", ratio.least}, {"most", ratio.most}};
    }
    contestants[name] = std::move(entry);
  }
  return {{"scene", cell.scene},
          {"rays", cell.rays},
          {"query", cell.query},
          {"count", cell.count},
          {"contestants", std::move(contestants)}};
}

Json to_json(const AnswerCheck& check) {
  return {{"rays", check.rays},
          {"mismatches", check.mismatches},
          {"any_mismatches", check.any_mismatches},
          {"judged", check.judged},
          {"sightline_wrong", check.sightline_wrong},
          {"inconsistent", check.inconsistent},
          {"embree_wrong", check.embree_wrong},
          {"ties", check.ties},
          {"example", check.example}};
}

Json to_json(const TraceResult& result) {
  Json json = {{"benchmark", "trace"},
               {"machine", result.machine},
               {"kernel", result.kernel},
               {"cpu", result.cpu},
               {"quick", result.quick},
               {"repetitions", result.repetitions},
               {"huge_kib", result.huge_kib},
               {"resident_kib", result.resident_kib},
               {"contestants", result.contestants}};
  for (const SceneFacts& scene : result.scenes) {
    json["scenes"].push_back({{"name", scene.name},
                              {"unique_triangles", scene.unique_triangles},
                              {"placed_triangles", scene.placed_triangles},
                              {"instances", scene.instances},
                              {"build_seconds", scene.build_seconds}});
  }
  for (const TraceCell& cell : result.cells) json["cells"].push_back(to_json(cell));
  for (const auto& [name, check] : result.checks) json["checks"][name] = to_json(check);
  for (const auto& [name, work] : result.work) json["work"][name] = work;
  json["floors"] = trace_floors(result);
  return json;
}

void write_csv(const TraceResult& result, std::ostream& out) {
  out << "scene,rays,query,count,contestant,ns_per_ray,least,most,speed,speed_least,speed_most\n";
  for (const TraceCell& cell : result.cells) {
    for (const std::string& name : result.contestants) {
      if (!cell.has(name)) continue;
      const Spread time = spread_of(cell.times.at(name));
      out << cell.scene << ',' << cell.rays << ',' << cell.query << ',' << cell.count << ',' << name
          << ',' << time.median << ',' << time.least << ',' << time.most;
      if (cell.has("embree1")) {
        const Spread ratio = speed_ratio(cell.times.at("embree1"), cell.times.at(name));
        out << ',' << ratio.median << ',' << ratio.least << ',' << ratio.most << '\n';
      } else {
        out << ",,,\n";
      }
    }
  }
}

void write_table(const TraceResult& result, const std::string& query, std::ostream& out) {
  out << "\n## " << (query == "closest" ? "Closest hit" : "Any hit")
      << "\n\nNanoseconds per ray; in brackets the speed against `embree1`, median (least to most "
         "of the repetitions).\n";
  for (const SceneFacts& scene : result.scenes) {
    std::vector<const TraceCell*> cells;
    for (const TraceCell& cell : result.cells) {
      if (cell.scene == scene.name && cell.query == query) cells.push_back(&cell);
    }
    if (cells.empty()) continue;
    out << "\n| " << scene.name << " |";
    for (const TraceCell* cell : cells) out << ' ' << cell->rays << " |";
    out << "\n|---|" << [&] {
      std::string dashes;
      for (std::size_t i = 0; i < cells.size(); ++i) dashes += "---:|";
      return dashes;
    }() << '\n';
    for (const std::string& name : result.contestants) {
      out << "| " << name << " |";
      for (const TraceCell* cell : cells) {
        if (!cell->has(name)) {
          out << " |";
          continue;
        }
        char text[96];
        if (cell->has("embree1")) {
          const Spread ratio = speed_ratio(cell->times.at("embree1"), cell->times.at(name));
          std::snprintf(text, sizeof text, " %.0f (%.2f, %.2f to %.2f) |", cell->median(name),
                        ratio.median, ratio.least, ratio.most);
        } else {
          std::snprintf(text, sizeof text, " %.0f |", cell->median(name));
        }
        out << text;
      }
      out << '\n';
    }
  }
}

void write_markdown(const TraceResult& result, std::ostream& out) {
  out << "# Trace: Sightline beside Embree 3.13.5\n\n"
      << result.machine << "; one thread pinned to CPU " << result.cpu << ", its own CPU time, "
      << result.repetitions << " interleaved repetitions" << (result.quick ? " (quick)" : "")
      << "; kernel " << result.kernel << "; " << result.huge_kib / 1024 << " of "
      << result.resident_kib / 1024 << " MiB on huge pages at the end.\n\n";
  for (const std::string& floor : trace_floors(result)) out << "- " << floor << '\n';
  write_table(result, "closest", out);
  write_table(result, "any", out);

  out << "\n## The answers\n\nMismatches are rays for which Sightline and `embree1` name different "
         "triangles. The oracle judged a sample of them and a sample of all rays.\n\n"
         "| scene and rays | rays | mismatches | any-hit mismatches | judged | Sightline wrong | "
         "inconsistent | Embree wrong | ties |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|\n";
  for (const auto& [name, c] : result.checks) {
    out << "| " << name << " | " << c.rays << " | " << c.mismatches << " | " << c.any_mismatches
        << " | " << c.judged << " | " << c.sightline_wrong << " | " << c.inconsistent << " | "
        << c.embree_wrong << " | " << c.ties << " |\n";
  }
  out << "\n## The work of a Sightline ray\n\n";
  for (const auto& [name, work] : result.work) out << "- " << name << ": " << work << '\n';
}

}  // namespace

bool write_trace_report(const TraceResult& result, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  std::ofstream json(folder + "/trace.json"), csv(folder + "/trace.csv"),
      markdown(folder + "/trace.md");
  json << to_json(result).dump(1) << '\n';
  write_csv(result, csv);
  write_markdown(result, markdown);
  return json.good() && csv.good() && markdown.good();
}

}  // namespace sightline::bench
