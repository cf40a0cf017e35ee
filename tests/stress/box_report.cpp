#include "tests/stress/box_report.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>

namespace sightline::stress {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kFloorRays = 10'000'000, kFloorTriangles = 2'000'000;
constexpr std::size_t kColumns = 6;  ///< contestants beside each other in one table

std::string number(std::uint64_t value) {
  std::string digits = std::to_string(value);
  for (std::size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, 1, ',');
  return digits;
}

std::string percent(std::uint64_t part, std::uint64_t whole) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f%%",
                whole == 0 ? 0.0 : 100 * static_cast<double>(part) / static_cast<double>(whole));
  return text;
}

std::vector<BoxFamilyResult> with_total(std::vector<BoxFamilyResult> results) {
  BoxTally total = total_of(results);
  results.push_back({"**all**", std::move(total)});
  return results;
}

void write_sightline(std::ostream& out, const std::vector<BoxFamilyResult>& results) {
  out << "| family | pairs judged | oriented | meet | touch exactly | Sightline wrong |\n"
         "|---|--:|--:|--:|--:|--:|\n";
  for (const auto& [family, t] : with_total(results)) {
    out << "| " << family << " | " << number(t.judged) << " | " << number(t.oriented) << " | "
        << percent(t.meet, t.judged) << " | " << percent(t.touching, t.judged) << " | "
        << number(t.wrong) << " |\n";
  }
}

void write_peers(std::ostream& out, const std::vector<BoxFamilyResult>& results) {
  const std::size_t count = results.empty() ? 0 : results[0].tally.peers.size();
  for (std::size_t begin = 0; begin < count; begin += kColumns) {
    const std::size_t end = std::min(count, begin + kColumns);
    out << "\n| family | asked |";
    for (std::size_t p = begin; p < end; ++p) out << ' ' << results[0].tally.peers[p].name << " |";
    out << "\n|---|--:|";
    for (std::size_t p = begin; p < end; ++p) out << "--:|";
    out << '\n';
    for (const auto& [family, tally] : with_total(results)) {
      const std::span<const BoxPeerTally> peers(tally.peers);
      if (peers.empty() || peers[0].asked == 0) continue;
      out << "| " << family << " | " << number(peers[0].asked) << " |";
      for (const BoxPeerTally& peer : peers.subspan(begin, end - begin)) {
        out << ' ' << number(peer.false_hits) << '/' << number(peer.false_misses) << " |";
      }
      out << '\n';
    }
  }
}

Json to_json(const std::string& family, const BoxTally& tally) {
  Json peers = Json::array();
  for (const BoxPeerTally& peer : tally.peers) {
    peers.push_back({{"name", peer.name},
                     {"asked", peer.asked},
                     {"false_hits", peer.false_hits},
                     {"false_misses", peer.false_misses}});
  }
  return {{"name", family},
          {"judged", tally.judged},
          {"oriented", tally.oriented},
          {"meet", tally.meet},
          {"touching", tally.touching},
          {"sightline_wrong", tally.wrong},
          {"others", std::move(peers)},
          {"failures", tally.failures}};
}

Json to_json(const std::vector<BoxFamilyResult>& results) {
  Json families = Json::array();
  for (const auto& [family, tally] : results) families.push_back(to_json(family, tally));
  return {{"families", std::move(families)}, {"all", to_json("all", total_of(results))}};
}

}  // namespace

BoxTally total_of(const std::vector<BoxFamilyResult>& results) {
  BoxTally total;
  for (const BoxFamilyResult& result : results) total.add(result.tally);
  return total;
}

std::string floor_line(const BoxRun& run) {
  const BoxTally rays = total_of(run.rays), triangles = total_of(run.triangles);
  const bool ok = rays.wrong + triangles.wrong == 0 && rays.judged >= kFloorRays &&
                  triangles.judged >= kFloorTriangles && rays.touching >= rays.judged / 3 &&
                  triangles.touching >= triangles.judged / 3;
  std::ostringstream out;
  out << "floor 5: " << rays.wrong << " wrong of " << rays.judged << " ray-box pairs, "
      << triangles.wrong << " of " << triangles.judged << " triangle-box pairs (needs 0) "
      << (ok ? "ok" : "short");
  return out.str();
}

std::string markdown(const BoxRun& run) {
  char minutes[32];
  std::snprintf(minutes, sizeof minutes, "%.1f", run.cpu_minutes);
  std::ostringstream out;
  out << "# Pairs with a box\n\nSeed " << run.seed << ", " << run.threads << " threads, " << minutes
      << " CPU minutes. Every pair is judged by rational arithmetic; Sightline by every field of "
         "its answer, the bits of each t included. A pair touches exactly when an equality "
         "decides.\n\n"
      << floor_line(run) << "\n\n## Rays and boxes\n\n";
  write_sightline(out, run.rays);
  out << "\nFalse hits/false misses of the literature's slab tests, on the same pairs less those "
         "with oriented boxes.\n";
  write_peers(out, run.rays);
  out << "\n## Triangles and boxes\n\n";
  write_sightline(out, run.triangles);
  out << "\nFalse hits/false misses of the literature's tests, on the same pairs less those with "
         "oriented boxes or triangles without area.\n";
  write_peers(out, run.triangles);
  return out.str();
}

std::string json(const BoxRun& run) {
  const Json all = {{"seed", std::to_string(run.seed)},       {"threads", run.threads},
                    {"cpu_minutes", run.cpu_minutes},         {"ray_box", to_json(run.rays)},
                    {"triangle_box", to_json(run.triangles)}, {"floors", {floor_line(run)}}};
  return all.dump(1) + "\n";
}

}  // namespace sightline::stress
