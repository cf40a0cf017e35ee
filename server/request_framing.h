#pragma once
/// Whether a request says without doubt where it ends and whom it is for: what two programs on the
/// way could read in two ways (RFC 9112, 3.2 and 6.3) is refused.

#include <httplib.h>

#include <optional>

namespace sightline {

struct FramingFault {
  const char* code;
  const char* detail;
};

/// HOST_INVALID: not exactly one Host (HTTP/1.0 may leave it out). FRAMING_AMBIGUOUS: more than one
/// Content-Length, or one that is no number; a Transfer-Encoding other than chunked, or together
/// with a Content-Length. After either, the connection has to end.
std::optional<FramingFault> find_framing_fault(const httplib::Request& request);

}  // namespace sightline
