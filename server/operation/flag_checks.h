#pragma once
/// Checks of the texts of flags. Each returns what is wrong, or nothing.

#include <chrono>
#include <string>

namespace sightline {

/// The library reads "-1" into an unsigned number as the largest one there is.
std::string check_positive_count(const std::string& text);
/// A NaN passes every comparison of a range that is written as two refusals.
std::string check_seconds(const std::string& text, double least);

inline std::chrono::milliseconds milliseconds_of(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

}  // namespace sightline
