#pragma once
/// Checks of the values of flags. Each returns the error, or an empty text.

#include <chrono>
#include <string>

namespace sightline {

/// Checks for a positive integer. (CLI11 reads "-1" into an unsigned number as the largest one.)
std::string check_positive_count(const std::string& text);
/// Checks for a number of seconds from `least` to 1,000,000; NaN is refused.
std::string check_seconds(const std::string& text, double least);

/// Whole milliseconds, rounded down. Precondition: checked by check_seconds.
inline std::chrono::milliseconds milliseconds_of(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

}  // namespace sightline

// Tests: tests/unit/server/cli_test.cpp
