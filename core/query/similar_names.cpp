#include "core/query/similar_names.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>

namespace sightline {

namespace {

constexpr std::size_t kMostNames = 3, kLongestName = 64;

char folded(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

std::string folded(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](char c) { return folded(c); });
  return result;
}

/// The edit distance of a name from the nearest text that a pattern matches: one row of the table
/// for each byte of the pattern [Wagner1974]. Two neighbours in the wrong order are one edit
/// [Damerau1964]. Precondition: at most kLongestName bytes.
std::size_t edits(std::string_view pattern, std::string_view name) {
  std::array<std::size_t, kLongestName + 1> row{}, above{}, above_that{};
  for (std::size_t j = 0; j <= name.size(); ++j) row[j] = j;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const char p = pattern[i];
    const bool is_star = p == '*';
    above_that = above;
    above = row;
    if (!is_star) ++row[0];
    for (std::size_t j = 1; j <= name.size(); ++j) {
      // A star matches any text for nothing, a question mark any byte.
      row[j] = is_star ? std::min(above[j], row[j - 1])
                       : std::min({above[j] + 1, row[j - 1] + 1,
                                   above[j - 1] + (p == '?' || p == name[j - 1] ? 0u : 1u)});
      const bool is_swapped = i > 0 && j > 1 && p == name[j - 2] && pattern[i - 1] == name[j - 1];
      if (is_swapped) row[j] = std::min(row[j], above_that[j - 2] + 1);
    }
  }
  return row[name.size()];
}

/// A pattern, and how far names are from it.
class Wanted {
 public:
  explicit Wanted(std::string_view pattern) : pattern_(folded(pattern)) {
    const auto stars = std::count(pattern_.begin(), pattern_.end(), '*');
    bytes_ = pattern_.size() - static_cast<std::size_t>(stars);
    has_star_ = stars > 0;
    is_plain_ = !has_star_ && pattern_.find('?') == std::string::npos;
    most_edits_ = std::max<std::size_t>((bytes_ + 1) / 3, 1);
  }
  /// Whether any name may be similar: one letter is similar to each other one.
  bool is_fit() const { return bytes_ >= 2 && bytes_ <= kLongestName + most_edits_; }

  /// Nothing where the name is too far. Adds what it took to `steps`.
  std::optional<std::size_t> distance(std::string_view name, std::uint64_t& steps) const {
    ++steps;
    if (name.empty() || name.size() > kLongestName || name.size() + most_edits_ < bytes_) return {};
    const bool is_long = !has_star_ && name.size() > bytes_ + most_edits_;
    if (is_long && !is_plain_) return {};
    const std::string text = folded(name);
    steps += text.size();
    if (is_plain_ && text.size() > bytes_ && text.find(pattern_) != std::string::npos) return 1;
    if (is_long) return {};
    steps += pattern_.size() * text.size();
    const std::size_t found = edits(pattern_, text);
    return found <= most_edits_ ? std::optional(found) : std::nullopt;
  }

 private:
  std::string pattern_;
  std::size_t bytes_ = 0;  ///< of the pattern without its stars
  bool has_star_ = false, is_plain_ = false;
  std::size_t most_edits_ = 1;
};

struct Candidate {
  std::string_view name;
  std::size_t edits = 0;
};

/// Retains the nearest ones in order.
void add(std::vector<Candidate>& best, const Candidate& next) {
  const auto is_it = [&](const Candidate& each) { return each.name == next.name; };
  if (std::any_of(best.begin(), best.end(), is_it)) return;
  const auto is_before = [](std::size_t edits, const Candidate& each) {
    return edits < each.edits;
  };
  best.insert(std::upper_bound(best.begin(), best.end(), next.edits, is_before), next);
  if (best.size() > kMostNames) best.pop_back();
}

}  // namespace

std::vector<std::string_view> similar_names(
    std::string_view pattern, std::size_t names,
    const std::function<std::string_view(std::size_t)>& name_at, std::uint64_t most_steps,
    DeadlineWatch& watch) {
  const Wanted wanted(pattern);
  std::vector<Candidate> best;
  std::uint64_t steps = 0;
  for (std::size_t i = 0; wanted.is_fit() && i < names && steps < most_steps; ++i) {
    const std::string_view name = name_at(i);
    const std::uint64_t before = steps;
    const auto distance = wanted.distance(name, steps);
    if (distance) add(best, {name, *distance});
    if (watch.passed(steps - before)) break;
  }
  std::vector<std::string_view> result;
  result.reserve(best.size());
  for (const Candidate& each : best) result.push_back(each.name);
  return result;
}

std::string similar_names_text(std::string_view pattern, std::size_t names,
                               const std::function<std::string_view(std::size_t)>& name_at,
                               std::uint64_t most_steps, DeadlineWatch& watch) {
  std::string text;
  std::string_view before = "; similar: \"";
  for (const std::string_view name : similar_names(pattern, names, name_at, most_steps, watch)) {
    text.append(before).append(name).append("\"");
    before = ", \"";
  }
  return text;
}

}  // namespace sightline
