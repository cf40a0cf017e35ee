#pragma once
/// Query parameters of a request: name=value, each name known and at most once.

#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "server/http/exchange.h"

namespace sightline {

class QueryParameters {
 public:
  /// Reads them from the target itself: the library's own reader takes "first=0;x=1" for x = 1.
  /// Nothing after it has answered 422 QUERY_INVALID, naming the known ones.
  static std::optional<QueryParameters> read(Exchange& exchange,
                                             std::initializer_list<std::string_view> known);

  std::optional<std::string_view> text(std::string_view name) const;
  /// Digits, from 0 to `most`; `value` stays what it is when the parameter is left out. False after
  /// it has answered 422 QUERY_INVALID.
  bool number(Exchange& exchange, std::string_view name, std::uint64_t most,
              std::uint64_t& value) const;

 private:
  std::map<std::string, std::string, std::less<>> values_;
};

}  // namespace sightline
