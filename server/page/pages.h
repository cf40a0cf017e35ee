#pragma once
/// The pages that the binary holds.

#include <string_view>

namespace sightline {

/// A text that browsers may cache.
struct PageText {
  std::string_view text;
  std::string_view tag;  ///< differs for another text; 32 hexadecimal digits
};

// The page at /docs shows the OpenAPI document. It says nothing of this server: what it shows it
// asks for.
PageText docs_page();    ///< HTML
PageText docs_script();  ///< JavaScript
PageText docs_style();   ///< CSS

// The pages at / and /learn: server/page/app, bundled by esbuild. A build without npm has a short
// page instead, which says how to build the full one.
PageText app_page();      ///< HTML
PageText app_script();    ///< JavaScript
PageText app_style();     ///< CSS
PageText learn_page();    ///< HTML
PageText learn_script();  ///< JavaScript

}  // namespace sightline
