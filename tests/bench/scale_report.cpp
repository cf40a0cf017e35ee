#include "tests/bench/scale_report.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <fstream>
#include <optional>

#include "tests/bench/machine.h"
#include "tests/bench/statistics.h"

namespace sightline::bench {

namespace {

const std::vector<std::string> kRays{"camera", "lidar", "ao", "incoherent"};

/// What grows.
struct Measure {
  const char* name;
  double ScaleRow::*value;
};
constexpr Measure kTime{"ns", &ScaleRow::ns_per_ray}, kWarm{"ns warm", &ScaleRow::warm_ns_per_ray},
    kLearned{"ns learned", &ScaleRow::learned_ns_per_ray},
    kNodes{"nodes", &ScaleRow::nodes_per_ray}, kEmbree1{"Embree single", &ScaleRow::embree1_ns},
    kEmbree{"Embree best", &ScaleRow::embree_ns};
constexpr Measure kMeasures[] = {kTime, kWarm, kLearned, kNodes, kEmbree1, kEmbree};

[[gnu::format(printf, 1, 2)]] std::string print(const char* format, ...) {
  char text[400];
  va_list values;
  va_start(values, format);
  std::vsnprintf(text, sizeof text, format, values);
  va_end(values);
  return text;
}

using Line = std::vector<ScaleRow>;  ///< of growing sizes

Line pick(const Line& rows, const std::string& subject, const std::string& rays) {
  Line picked;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(picked),
               [&](const ScaleRow& row) { return row.subject == subject && row.rays == rays; });
  return picked;
}

double logarithm(const ScaleRow& row) { return std::log2(static_cast<double>(row.size)); }

/// Least squares of value = a + b log2(size), and which share of the variance that explains.
struct Fit {
  double a = 0, b = 0, explained = 1;
};
Fit fit_logarithm(const Line& rows, const Measure& measure) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (const ScaleRow& row : rows) {
    const double x = logarithm(row), y = row.*measure.value;
    n += 1;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
    syy += y * y;
  }
  if (n < 2) return {n == 0 ? 0 : sy, 0, 1};
  const double b = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  const double all = n * syy - sy * sy;
  return {(sy - b * sx) / n, b, all > 0 ? b * (n * sxy - sx * sy) / all : 1};
}

double last_level_bytes() {
  std::ifstream file("/sys/devices/system/cpu/cpu0/cache/index3/size");
  double kib = 32 * 1024;
  file >> kib;
  return kib * 1024;
}

/// Those whose tree fits the last-level cache; or the others, after the last that does.
Line part_of(const Line& line, bool fits) {
  const double cache = last_level_bytes();
  const auto end = std::find_if(line.begin(), line.end(),
                                [&](const ScaleRow& row) { return row.tree_bytes > cache; });
  if (fits) return {line.begin(), end};
  return {end == line.begin() ? end : end - 1, line.end()};
}

/// From the smallest to the largest terrain over that of the logarithm: 1 if it were proportional
/// to it. None where something was not measured.
std::optional<double> growth(const Line& line, const Measure& measure) {
  if (line.size() < 2) return {};
  const double before = line.front().*measure.value, after = line.back().*measure.value;
  if (!(before > 0 && after > 0)) return {};
  return after / before / (logarithm(line.back()) / logarithm(line.front()));
}
std::vector<double> growths(const Line& rows, const Measure& measure) {
  std::vector<double> all;
  for (const std::string& rays : kRays) {
    if (const auto one = growth(pick(rows, "triangles", rays), measure)) all.push_back(*one);
  }
  return all;
}
double mean_growth(const Line& rows, const Measure& measure) {
  const std::vector<double> all = growths(rows, measure);
  return all.empty() ? 0 : geometric_mean(all);
}

void write_growth(const Line& rows, std::ostream& markdown) {
  markdown << "\n## Growth over that of the logarithm\n\n"
              "From the smallest to the largest terrain.\n\n|";
  for (const Measure& measure : kMeasures) markdown << " | " << measure.name;
  markdown << " |\n|---|--:|--:|--:|--:|--:|--:|\n";
  for (const std::string& rays : kRays) {
    markdown << "| " << rays;
    for (const Measure& measure : kMeasures)
      markdown << print(" | %.2f", growth(pick(rows, "triangles", rays), measure).value_or(0));
    markdown << " |\n";
  }
  markdown << "| mean";
  for (const Measure& measure : kMeasures) markdown << print(" | %.2f", mean_growth(rows, measure));
  markdown << " |\n";
}

void write_fits(const Line& rows, const std::string& subject, nlohmann::ordered_json& json,
                std::ostream& markdown) {
  markdown << "\nFitted: a + b log2(size), the share of the variance that this explains, and b of "
              "the sizes whose tree fits the last-level cache and of those beyond.\n\n"
              "| rays | of | a | b | explained | b within | b beyond |\n"
              "|---|---|--:|--:|--:|--:|--:|\n";
  for (const std::string& rays : kRays) {
    const Line line = pick(rows, subject, rays);
    nlohmann::ordered_json entry = {{"subject", subject}, {"rays", rays}};
    for (const Measure& measure : kMeasures) {
      if (line.empty() || !(line.front().*measure.value > 0)) continue;
      const Fit fit = fit_logarithm(line, measure);
      const Line within = part_of(line, true), beyond = part_of(line, false);
      const auto slope = [&](const Line& part) {
        return part.size() < 2 ? std::string("-") : print("%.2f", fit_logarithm(part, measure).b);
      };
      entry[measure.name] = {{"a", fit.a}, {"b", fit.b}, {"explained", fit.explained}};
      markdown << print("| %s | %s | %.2f | %.2f | %.0f%% | %s | %s |\n", rays.c_str(),
                        measure.name, fit.a, fit.b, 100 * fit.explained, slope(within).c_str(),
                        slope(beyond).c_str());
    }
    json["fits"].push_back(entry);
  }
}

void write_rows(const Line& rows, const std::string& subject, std::ostream& markdown) {
  markdown
      << "\n| " << subject
      << " | rays | ns per ray | warm | learned | nodes | blocks | Embree single | Embree best "
         "| build, s | tree, MiB | peak, MiB |\n"
         "|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
  for (const ScaleRow& row : rows) {
    if (row.subject != subject) continue;
    const bool embree = row.embree_ns > 0;
    markdown << print("| %llu | %s | %.0f (%.0f to %.0f) | %.0f | %.0f | %.1f | %.1f",
                      static_cast<unsigned long long>(row.size), row.rays.c_str(), row.ns_per_ray,
                      row.least, row.most, row.warm_ns_per_ray, row.learned_ns_per_ray,
                      row.nodes_per_ray, row.blocks_per_ray)
             << (embree
                     ? print(" | %.0f | %.0f %s", row.embree1_ns, row.embree_ns, row.embree.c_str())
                     : std::string(" | - | -"))
             << print(" | %.2f | %.1f | %.0f |\n", row.build_seconds, row.tree_bytes / (1 << 20),
                      row.peak_mib);
  }
}

void write_columns(const Line& rows, std::ostream& csv) {
  csv << "subject,rays,size,ns_per_ray,least,most,warm_ns_per_ray,learned_ns_per_ray,"
         "nodes_per_ray,blocks_per_ray,build_seconds,tree_bytes,peak_mib,embree1_ns,embree_ns,"
         "embree\n";
  for (const ScaleRow& row : rows) {
    csv << row.subject << ',' << row.rays << ',' << row.size << ',' << row.ns_per_ray << ','
        << row.least << ',' << row.most << ',' << row.warm_ns_per_ray << ','
        << row.learned_ns_per_ray << ',' << row.nodes_per_ray << ',' << row.blocks_per_ray << ','
        << row.build_seconds << ',' << row.tree_bytes << ',' << row.peak_mib << ','
        << row.embree1_ns << ',' << row.embree_ns << ',' << row.embree << '\n';
  }
}

}  // namespace

std::vector<std::string> scale_floors(const std::vector<ScaleRow>& rows) {
  std::vector<std::string> lines;
  const ScaleRow* largest = nullptr;
  for (const ScaleRow& row : rows) {
    if (row.subject == "triangles" && (largest == nullptr || row.size > largest->size)) {
      largest = &row;
    }
  }
  if (largest != nullptr) {
    const bool ok = largest->size >= 16'000'000 && largest->peak_mib <= 4096;
    lines.push_back(print(
        "floor 7: %.2f (needs at most 4) %s  GiB at the peak with %.1f M triangles, "
        "making the scene included",
        largest->peak_mib / 1024, ok ? "ok" : "short", static_cast<double>(largest->size) / 1e6));
  }
  if (const std::size_t kinds = growths(rows, kTime).size(); kinds > 0) {
    const double time = mean_growth(rows, kTime);
    lines.push_back(
        print("floor 7: %.2f (needs at most 1) %s  growth of ns per ray from the smallest to "
              "the largest terrain over that of the logarithm, mean of %zu kinds of rays "
              "(warm: %.2f, nodes per ray: %.2f)",
              time, time <= 1 ? "ok" : "short", kinds, mean_growth(rows, kWarm),
              mean_growth(rows, kNodes)));
  }
  return lines;
}

std::vector<std::string> scale_growth(const std::vector<ScaleRow>& rows) {
  std::vector<std::string> lines;
  if (growths(rows, kEmbree1).empty()) return lines;
  lines.push_back(
      print("growth: %.2f Embree's single rays, %.2f its best entry of each size, by the same "
            "formula; %.2f Sightline, %.2f with warm caches",
            mean_growth(rows, kEmbree1), mean_growth(rows, kEmbree), mean_growth(rows, kTime),
            mean_growth(rows, kWarm)));
  for (const std::string& rays : kRays) {
    const Line line = pick(rows, "triangles", rays);
    const Line within = part_of(line, true), beyond = part_of(line, false);
    const auto slopes = [&](const Measure& measure) {
      return print("%s %.1f and %.1f (a line explains %.0f%%)", measure.name,
                   fit_logarithm(within, measure).b, fit_logarithm(beyond, measure).b,
                   100 * fit_logarithm(line, measure).explained);
    };
    lines.push_back("growth: " + rays +
                    ", per doubling in the caches and beyond: " + slopes(kTime) + ". " +
                    slopes(kWarm) + ". " + slopes(kNodes) + ". " + slopes(kEmbree));
  }
  return lines;
}

bool write_scale_report(const std::vector<ScaleRow>& rows, const std::string& folder) {
  nlohmann::ordered_json json = {{"benchmark", "scale"}, {"machine", machine_name()}};
  json["rows"] = nlohmann::json(rows);
  std::ofstream csv(folder + "/scale.csv"), markdown(folder + "/scale.md");
  write_columns(rows, csv);
  markdown << "# Scale: how time and memory grow\n\n![Scale](scale.png)\n\n"
           << machine_name()
           << "; closest hit, one pinned thread, its own CPU time; every size in a process of its "
              "own, and Embree in another. Triangles: one terrain. Instances: copies of a ball of "
              "2,000 triangles. Nodes and blocks are what a ray visits: they do not know caches, "
              "the time does. Warm: batches of 512 rays whose nodes another kernel has just "
              "visited. Learned: batches that the same kernel has just traced, so that the "
              "processor foresees its branches too. Embree: single rays, and the best of single, "
              "packets of 8 and 16, and stream, coherent or not, default flags.\n\n";
  for (const std::string& floor : scale_floors(rows)) markdown << "- " << floor << '\n';
  for (const std::string& line : scale_growth(rows)) markdown << "- " << line << '\n';
  write_growth(rows, markdown);
  for (const char* subject : {"triangles", "instances"}) {
    markdown << "\n## " << subject << '\n';
    write_fits(rows, subject, json, markdown);
    write_rows(rows, subject, markdown);
  }
  json["floors"] = scale_floors(rows);
  json["growth"] = scale_growth(rows);
  std::ofstream out(folder + "/scale.json");
  out << json.dump(1) << '\n';
  return out.good() && csv.good() && markdown.good();
}

}  // namespace sightline::bench
