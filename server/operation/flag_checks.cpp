#include "server/operation/flag_checks.h"

#include <charconv>
#include <sstream>

namespace sightline {

std::string check_positive_count(const std::string& text) {
  std::uint64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value);
  const bool good = error == std::errc() && last == end && value > 0;
  return good ? "" : "'" + text + "' is not a whole number from 1 on";
}

std::string check_seconds(const std::string& text, double least) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value);
  const bool good = error == std::errc() && last == end && value >= least && value <= 1e6;
  std::ostringstream range;
  range << least << " to 1000000";
  return good ? "" : "'" + text + "' is not a number of seconds from " + range.str();
}

}  // namespace sightline
