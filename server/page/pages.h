#pragma once
/// The pages that are part of the binary.

#include <span>
#include <string_view>

namespace sightline {

/// A text that browsers may cache; part of the program, so it is always valid.
struct PageText {
  std::string_view text;
  std::string_view tag;  ///< hash of the text, 32 hexadecimal digits
};

// The page at /docs, which shows the OpenAPI document. It contains nothing of this server; it
// requests what it shows.
PageText docs_page();    ///< HTML
PageText docs_script();  ///< JavaScript
PageText docs_style();   ///< CSS

/// The files of the other pages: server/page/app, bundled by esbuild. A build without npm has a
/// short page instead, which tells how to build the full ones.
struct PagePart {
  std::string_view name;  ///< name of the file: "index.html"
  std::string_view media_type;
  PageText what;
};
/// All files of the other pages.
std::span<const PagePart> page_parts();

/// Paths of the repository's documents: below docs ("guides/page.md"), or at the top ("README.md").
/// The part documents.json.gz has their texts.
std::span<const std::string_view> page_documents();

}  // namespace sightline

// Tests: tests/integration/page_test.py
