#include "server/http/query_parameters.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "server/http/ascii.h"

namespace sightline {
namespace {

/// As forms are encoded: a plus sign is a space.
bool decode_value(std::string_view text, std::string& value) {
  std::string spaced(text);
  std::replace(spaced.begin(), spaced.end(), '+', ' ');
  return decode_percent(spaced, value);
}

}  // namespace

std::optional<QueryParameters> QueryParameters::read(
    Exchange& exchange, std::initializer_list<std::string_view> known) {
  QueryParameters parameters;
  std::string_view query = exchange.head.target;
  query.remove_prefix(std::min(query.find('?'), query.size()));
  while (!query.empty()) {
    query.remove_prefix(1);  // the '?' or '&'
    const std::string_view part = query.substr(0, query.find('&'));
    query.remove_prefix(part.size());
    if (part.empty()) continue;
    const std::size_t equals = part.find('=');
    const std::string_view name = part.substr(0, equals);
    const bool good =
        equals != std::string_view::npos &&
        std::find(known.begin(), known.end(), name) != known.end() &&
        parameters.values_.try_emplace(std::string(name), part.substr(equals + 1)).second;
    if (good) continue;
    std::string list;
    for (const std::string_view each : known) {
      list += (list.empty() ? "" : ", ") + std::string(each);
    }
    exchange.reply_problem(422, "QUERY_INVALID",
                           known.size() == 0
                               ? "there are no query parameters here"
                               : "the query parameters here are " + list +
                                     ", each name=value at most once, with & between them");
    return std::nullopt;
  }
  return parameters;
}

std::optional<std::string_view> QueryParameters::text(std::string_view name) const {
  const auto found = values_.find(name);
  if (found == values_.end()) return std::nullopt;
  return found->second;
}

bool QueryParameters::decoded(Exchange& exchange, std::string_view name, std::size_t most,
                              std::optional<std::string>& value) const {
  const auto given = text(name);
  if (!given) return true;
  std::string decoded;
  const bool good = decode_value(*given, decoded) && decoded.size() <= most;
  if (good) {
    value = std::move(decoded);
  } else {
    exchange.reply_problem(422, "QUERY_INVALID",
                           std::string(name) + " is percent-encoded text of at most " +
                               std::to_string(most) + " bytes");
  }
  return good;
}

bool QueryParameters::number(Exchange& exchange, std::string_view name, std::uint64_t most,
                             std::uint64_t& value) const {
  const auto given = text(name);
  if (!given) return true;
  const char* end = given->data() + given->size();
  std::uint64_t number = 0;
  const auto [last, error] = std::from_chars(given->data(), end, number);
  if (error == std::errc() && last == end && number <= most) {
    value = number;
    return true;
  }
  exchange.reply_problem(422, "QUERY_INVALID",
                         std::string(name) + " is a number from 0 to " + std::to_string(most));
  return false;
}

bool QueryParameters::point(Exchange& exchange, std::string_view name,
                            std::optional<std::array<double, 3>>& value) const {
  const auto given = text(name);
  if (!given) return true;
  const char *next = given->data(), *const end = next + given->size();
  std::array<double, 3> numbers{};
  bool is_good = true;
  for (std::size_t i = 0; i < numbers.size() && is_good; ++i) {
    if (i > 0) is_good = next != end && *next++ == ',';
    if (!is_good) break;
    const auto [last, error] = std::from_chars(next, end, numbers[i]);
    is_good = error == std::errc() && std::isfinite(numbers[i]);
    next = last;
  }
  if (is_good && next == end) {
    value = numbers;
    return true;
  }
  exchange.reply_problem(422, "QUERY_INVALID",
                         std::string(name) + " is three finite numbers with commas between them");
  return false;
}

}  // namespace sightline
