#pragma once
/// Answers to requests that the event loop refuses.

#include <string>
#include <string_view>

#include "server/http/request_head.h"

namespace sightline {

/// A whole answer as it goes over the wire: problem+json with the fault's status, code and detail;
/// after it the connection ends. An answer to HEAD comes without its body. `headers` are whole
/// lines.
std::string refusal_text(const RequestFault& fault, const std::string& request_id,
                         std::string_view headers, bool with_body);

}  // namespace sightline
