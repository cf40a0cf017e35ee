#pragma once
/// The pages that the binary holds.

#include <span>
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

/// The other pages: server/page/app, bundled by esbuild. A build without npm has a short page
/// instead, which says how to build the full ones.
struct PagePart {
  std::string_view name;  ///< of the file: "index.html"
  std::string_view media_type;
  PageText what;
};
std::span<const PagePart> page_parts();

/// The documents of the repository, by their paths below docs ("guides/page.md") or at the top
/// ("README.md"). The part documents.json.gz has their texts.
std::span<const std::string_view> page_documents();

}  // namespace sightline
