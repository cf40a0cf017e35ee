#pragma once
/// QueryParameters: the parameters name=value of a request target. Each name must be known, and
/// given at most once.

#include <array>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "server/http/exchange.h"

namespace sightline {

/// The parameters of one request. Names and values are not percent-decoded.
class QueryParameters {
 public:
  /// Reads the parameters. Empty after it has answered 422 QUERY_INVALID, which lists the known
  /// names. Only "&" separates parameters.
  static std::optional<QueryParameters> read(Exchange& exchange,
                                             std::initializer_list<std::string_view> known);

  /// The value of a parameter; empty if it was not given. Valid while this object lives.
  std::optional<std::string_view> text(std::string_view name) const;
  /// Reads text of at most `most` bytes: percent sequences are decoded, and a plus sign is a space.
  /// `value` is unchanged if the parameter was not given. Returns false after it has answered 422
  /// QUERY_INVALID.
  bool decoded(Exchange& exchange, std::string_view name, std::size_t most,
               std::optional<std::string>& value) const;
  /// Reads an integer from 0 to `most`. Returns true with `value` unchanged if the parameter was
  /// not given. Returns false with `value` unchanged after it has answered 422 QUERY_INVALID.
  bool number(Exchange& exchange, std::string_view name, std::uint64_t most,
              std::uint64_t& value) const;
  /// Reads a point: three finite numbers with commas between them. `value` is unchanged if the
  /// parameter was not given. Returns false after it has answered 422 QUERY_INVALID.
  bool point(Exchange& exchange, std::string_view name,
             std::optional<std::array<double, 3>>& value) const;

 private:
  std::map<std::string, std::string, std::less<>> values_;
};

}  // namespace sightline

// Tests: tests/integration/scenes_test.py
