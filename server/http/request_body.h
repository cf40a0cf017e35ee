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
#include "server/http/exchange.h"

namespace sightline {

/// What the request says of its length; empty for a chunked body.
std::optional<std::uint64_t> body_length(const Exchange& exchange);

/// What can be said of a body before it is read. Errors: LENGTH_REQUIRED (neither Content-Length
/// nor chunked; status 411, so it is answered here), BODY_TOO_LARGE, ENCODING_UNSUPPORTED. Returns
/// false after it has answered.
bool admit_body(Exchange& exchange, std::uint64_t limit);

/// Admits a body of any length that is answered while it arrives. Errors: LENGTH_REQUIRED,
/// ENCODING_UNSUPPORTED. Returns false after it has answered.
bool admit_stream(Exchange& exchange);

/// What is wrong with a body that could not be read to its end: BODY_INCOMPLETE, ENCODING_BROKEN,
/// REQUEST_TIMEOUT (kDeadline) or MEMORY_BUSY (kBusy). `body` may be null.
Error body_fault(const BodyReader* body);
/// Answers so: 400, 408 for a slow one, or 503.
void reply_body_fault(Exchange& exchange);

/// Whether all of the body is here, or more of it than the limit. Where not, the request is put
/// off: the handler returns and is called again. Precondition: admit_body was true.
bool is_body_here(const Exchange& exchange, std::uint64_t limit);

/// Passes on the part of the body that has arrived, decoded; the limit counts decoded bytes. If the
/// body is not complete, it stores `state` in BodyReader::kept, puts the request off and returns
/// false; the handler is called again for the next part. A body with a Content-Encoding is passed
/// on when it is complete, so its handler calls is_body_here first. Returns false also after it has
/// answered: BODY_TOO_LARGE, BODY_INCOMPLETE (the client stopped, or broke the framing), or the
/// error of `sink`. Precondition: admit_body was true.
bool read_body_in_parts(Exchange& exchange, std::uint64_t limit, std::shared_ptr<void> state,
                        const std::function<Status(std::span<const char>)>& sink);

/// The whole body as text, which may hold its begin already, with `spare` bytes of capacity to
/// come, and the memory to decode it. False where the request was put off, and after it has
/// answered, also 503 MEMORY_BUSY and 413 REQUEST_TOO_LARGE.
bool read_body(Exchange& exchange, std::uint64_t limit, std::size_t spare, std::string& text);
/// What that memory is. Errors: see RequestMemory.
Status reserve_decoding(RequestMemory* memory, std::string_view body);
/// After decoding: the body goes, and of the memory all but `bytes`.
void forget_body(Exchange& exchange, std::string& text, std::uint64_t bytes);

}  // namespace sightline
