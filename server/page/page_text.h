#pragma once
/// A text that is embedded in the binary and that browsers may cache.

#include <string_view>

namespace sightline {

struct PageText {
  std::string_view text;
  std::string_view tag;  ///< differs for another text; 32 hexadecimal digits
};

}  // namespace sightline
