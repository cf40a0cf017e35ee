#pragma once
/// The page that shows the OpenAPI document to people: server/docs as it stands there. It says
/// nothing of this server: what it shows it asks for.

#include <string_view>

namespace sightline {

struct PageText {
  std::string_view text;
  std::string_view tag;  ///< other for another text; 32 hexadecimal digits
};

PageText docs_page();    ///< HTML
PageText docs_script();  ///< JavaScript
PageText docs_style();   ///< CSS

}  // namespace sightline
