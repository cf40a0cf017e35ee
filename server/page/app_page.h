#pragma once
/// The pages at / and /learn: server/page/app, bundled by esbuild. A build without npm has a short page
/// instead, which says how to build the full one.

#include "server/page/page_text.h"

namespace sightline {

PageText app_page();    ///< HTML
PageText app_script();  ///< JavaScript
PageText app_style();   ///< CSS

PageText learn_page();    ///< HTML
PageText learn_script();  ///< JavaScript

}  // namespace sightline
