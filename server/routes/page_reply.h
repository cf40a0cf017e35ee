#pragma once
/// Answers with texts that are embedded in the binary.

#include <string_view>

#include "server/http/exchange.h"
#include "server/page/page_text.h"

namespace sightline {

/// 200, or 304 where If-None-Match names the text. The tag is weak: an answer may be compressed.
void reply_tagged(Exchange& exchange, PageText what, std::string_view media_type);
/// reply_tagged for a part of a page: browsers may cache it and ask whether it still holds.
void reply_page(Exchange& exchange, PageText what, std::string_view media_type);
/// reply_page for HTML, with the policy that the page may run its own script and ask this server,
/// and nothing else.
void reply_markup(Exchange& exchange, PageText what);

}  // namespace sightline
