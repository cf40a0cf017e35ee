#pragma once
/// The page that shows the OpenAPI document to people: server/docs as it stands there. It says
/// nothing of this server: what it shows it asks for.

#include "server/page/page_text.h"

namespace sightline {

PageText docs_page();    ///< HTML
PageText docs_script();  ///< JavaScript
PageText docs_style();   ///< CSS

}  // namespace sightline
