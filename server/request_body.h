#pragma once
/// Reads a request's body under a limit.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "server/exchange.h"

namespace sightline {

/// What the request says of its length; empty for a chunked body.
std::optional<std::uint64_t> body_length(const Exchange& exchange);

/// What can be said of a body before it is read. Errors: LENGTH_REQUIRED (neither Content-Length
/// nor chunked; status 411, so it is answered here), BODY_TOO_LARGE, ENCODING_UNSUPPORTED. Returns
/// false after it has answered.
bool admit_body(Exchange& exchange, std::uint64_t limit);

/// The same for a body of any length that is answered while it comes.
bool admit_stream(Exchange& exchange);

/// Whether there is a Content-Type.
bool says_media_type(const Exchange& exchange);

/// 415 MEDIA_TYPE_UNSUPPORTED unless Content-Type is one of `accepted` (parameters are ignored), is
/// left out, or is one of `tolerated`, which the answer does not advertise. Returns false after it
/// has answered.
bool admit_media_type(Exchange& exchange, std::initializer_list<std::string_view> accepted,
                      std::initializer_list<std::string_view> tolerated = {});

/// What `curl -d` sends when nobody tells it otherwise.
inline constexpr std::string_view kFormMediaType = "application/x-www-form-urlencoded";

/// The media types of queries: JSON, also when it comes as a form. A browser sends forms across
/// sites without asking; that can do no harm here, because a query changes nothing and its answer
/// is not shown to the site. Returns false after it has answered.
bool admit_query_type(Exchange& exchange);

/// The same for rays and points, which come as bytes too, and rays as lines where `takes_lines`.
/// Nothing after it has answered.
enum class QueryType { kJson, kBinary, kLines };
std::optional<QueryType> admit_rays_type(Exchange& exchange, bool takes_lines = false);

/// What is wrong with a body that could not be read to its end: BODY_INCOMPLETE, ENCODING_BROKEN,
/// REQUEST_TIMEOUT (kDeadline) or MEMORY_BUSY (kBusy). `body` may be null.
Error body_fault(const BodyReader* body);
/// Answers so: 400, 408 for a slow one, or 503.
void reply_body_fault(Exchange& exchange);

/// Hands the body on in pieces, decoded; the limit is of what is handed on. Returns false after it
/// has answered: BODY_TOO_LARGE, BODY_INCOMPLETE (the client stopped, or broke the framing), 408
/// REQUEST_TIMEOUT, or what `sink` said. Precondition: admit_body was true.
bool read_body(Exchange& exchange, std::uint64_t limit,
               const std::function<Status(std::span<const char>)>& sink);

/// The whole body as text, which may hold its begin already, with `spare` bytes of capacity to
/// come, and the memory to decode it; or false after it has answered, also 503 MEMORY_BUSY and 413
/// REQUEST_TOO_LARGE.
bool read_body(Exchange& exchange, std::uint64_t limit, std::size_t spare, std::string& text);
/// What that memory is. Errors: see RequestMemory.
Status reserve_decoding(RequestMemory* memory, std::string_view body);
/// After decoding: the body goes, and of the memory all but `bytes`.
void forget_body(Exchange& exchange, std::string& text, std::uint64_t bytes);

}  // namespace sightline
