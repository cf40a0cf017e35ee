#include "tests/stress/report.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <sstream>
#include <utility>

namespace sightline::stress {
namespace {

std::string number(std::uint64_t value) {
  std::string digits = std::to_string(value);
  for (std::size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, ",");
  return digits;
}

std::string short_number(double value) {
  if (std::isinf(value)) return "inf";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(),
                value == 0 || (value >= 0.01 && value < 1e5) ? "%.3g" : "%.1e", value);
  return text.data();
}

std::string counts(std::uint64_t hits, std::uint64_t misses, std::uint64_t wrong) {
  if (hits + misses + wrong == 0) return "0";
  return number(hits) + "/" + number(misses) + "/" + number(wrong);
}

std::string json_number(double value) {
  if (!std::isfinite(value)) return "null";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  return text.data();
}

std::string json_string(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (c == '\n') {
      result += "\\n";
    } else {
      result += c;
    }
  }
  return result + "\"";
}

FamilyTally total_of(const std::vector<FamilyResult>& results) {
  FamilyTally total;
  for (const FamilyResult& result : results) total.add(result.tally);
  return total;
}

void write_row(std::ostream& out, const std::string& name, const FamilyTally& tally) {
  const SightlineTally& s = tally.sightline;
  out << "| " << name << " | " << number(s.rays) << " | " << number(s.hits) << " | "
      << number(s.wrong()) << " |";
  for (const PeerTally& p : tally.peers) {
    out << " ";
    if (p.asked == 0) {
      out << "not asked";
    } else {
      out << counts(p.false_hits, p.false_misses, p.wrong_primitive);
    }
    out << " |";
  }
  out << "\n";
}

void write_t_row(std::ostream& out, const std::string& name, const FamilyTally& tally) {
  out << "| " << name << " | " << number(tally.sightline.t_bits) << " |";
  for (const PeerTally& p : tally.peers) {
    if (p.t_error.count() == 0) {
      out << " - |";
    } else {
      out << " " << short_number(p.t_error.median()) << " / " << short_number(p.t_error.worst())
          << " |";
    }
  }
  out << "\n";
}

void write_header(std::ostream& out, std::vector<std::string> columns) {
  columns.insert(columns.end(), kPeerNames.begin(), kPeerNames.end());
  out << "|";
  for (const std::string& column : columns) out << " " << column << " |";
  out << "\n|";
  for (std::size_t i = 0; i < columns.size(); ++i) out << "---|";
  out << "\n";
}

void write_sightline(std::ostream& out, const SightlineTally& s) {
  const std::pair<const char*, std::uint64_t> fields[] = {{"rays", s.rays},
                                                          {"hits", s.hits},
                                                          {"lists", s.lists},
                                                          {"parities", s.parities},
                                                          {"wrong", s.wrong()},
                                                          {"false_hits", s.false_hits},
                                                          {"false_misses", s.false_misses},
                                                          {"wrong_primitive", s.wrong_primitive},
                                                          {"t_bits", s.t_bits},
                                                          {"any", s.any},
                                                          {"all", s.all},
                                                          {"count", s.count},
                                                          {"once", s.once},
                                                          {"parity", s.parity},
                                                          {"position", s.position},
                                                          {"barycentric", s.barycentric},
                                                          {"normal", s.normal},
                                                          {"front", s.front}};
  out << "{";
  for (const auto& [name, value] : fields) out << '"' << name << "\":" << value << ",";
  out << "\"worst_position_ulp\":" << json_number(s.worst_position_ulp)
      << ",\"worst_barycentric\":" << json_number(s.worst_barycentric)
      << ",\"worst_normal\":" << json_number(s.worst_normal) << "}";
}

void write_peer(std::ostream& out, const char* name, const PeerTally& peer) {
  out << "{\"name\":" << json_string(name) << ",\"asked\":" << peer.asked
      << ",\"false_hits\":" << peer.false_hits << ",\"false_misses\":" << peer.false_misses
      << ",\"wrong_primitive\":" << peer.wrong_primitive
      << ",\"other_of_tie\":" << peer.other_of_tie
      << ",\"t_median_ulp\":" << json_number(peer.t_error.median())
      << ",\"t_worst_ulp\":" << json_number(peer.t_error.worst()) << "}";
}

}  // namespace

std::string markdown(const std::vector<FamilyResult>& results, const RunFacts& facts) {
  const FamilyTally total = total_of(results);
  const SightlineTally& s = total.sightline;
  std::ostringstream out;
  out << "# Stress run\n\nSeed " << facts.seed << ", " << short_number(facts.minutes)
      << " minutes, kernels";
  for (const std::string& kernel : facts.kernels) out << " " << kernel;
  out << ". Judged by rational arithmetic: " << number(s.rays) << " rays (" << number(s.hits)
      << " hits) in the modes closest and any, with position, normal and barycentrics; "
      << number(s.lists) << " of them in the modes all and count; " << number(s.parities)
      << " whole lines through closed meshes whose crossings were counted once.\n\n"
      << "**Sightline wrong: " << number(s.wrong()) << "**\n\n## Wrong answers\n\n"
      << "False hits / false misses / wrong primitive (a triangle that is not at the exact closest "
         "t). Sightline's column counts every broken promise, the bits of t and the choice among "
         "ties included; naming another triangle of a tie is not held against the others.\n\n";
  write_header(out, {"family", "rays", "hits", "Sightline"});
  for (const FamilyResult& result : results) write_row(out, result.family.name, result.tally);
  write_row(out, "**all**", total);
  out << "\n## Error of t in float64 ulp, median / worst\n\n"
      << "Sightline's column counts the hits whose t is not bit-equal to the exact t rounded.\n\n";
  write_header(out, {"family", "Sightline"});
  for (const FamilyResult& result : results) write_t_row(out, result.family.name, result.tally);
  write_t_row(out, "**all**", total);
  out << "\nSightline's worst detail: position " << short_number(s.worst_position_ulp)
      << " ulp, barycentrics " << short_number(s.worst_barycentric) << ", normal "
      << short_number(s.worst_normal) << ".\n\n## Families\n\n";
  for (const FamilyResult& result : results)
    out << "- `" << result.family.name << "`: " << result.family.what << "\n";
  if (!total.failures.empty()) out << "\n## Sightline's wrong answers\n\n";
  for (const FamilyResult& result : results) {
    for (const std::string& failure : result.tally.failures) out << "```\n" << failure << "\n```\n";
  }
  return out.str();
}

std::string json(const std::vector<FamilyResult>& results, const RunFacts& facts) {
  std::ostringstream out;
  out << "{\"seed\":\"" << facts.seed << "\",\"minutes\":" << json_number(facts.minutes)
      << ",\"kernels\":[";
  for (std::size_t i = 0; i < facts.kernels.size(); ++i)
    out << (i == 0 ? "" : ",") << json_string(facts.kernels[i]);
  out << "],\"families\":[";
  for (std::size_t i = 0; i < results.size(); ++i) {
    const FamilyTally& tally = results[i].tally;
    out << (i == 0 ? "\n" : ",\n") << "{\"name\":" << json_string(results[i].family.name)
        << ",\"what\":" << json_string(results[i].family.what)
        << ",\"seconds\":" << json_number(tally.seconds) << ",\"sightline\":";
    write_sightline(out, tally.sightline);
    out << ",\"others\":[";
    for (std::size_t p = 0; p < tally.peers.size(); ++p) {
      out << (p == 0 ? "" : ",");
      write_peer(out, kPeerNames[p], tally.peers[p]);
    }
    out << "]}";
  }
  out << "\n],\"failures\":[";
  bool first = true;
  for (const FamilyResult& result : results) {
    for (const std::string& failure : result.tally.failures) {
      out << (first ? "" : ",") << json_string(failure);
      first = false;
    }
  }
  out << "]}\n";
  return out.str();
}

}  // namespace sightline::stress
