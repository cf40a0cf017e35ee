#pragma once
/// Reads a request's body, up to a limit.

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

/// The length that the request states; empty for a chunked body.
std::optional<std::uint64_t> body_length(const Exchange& exchange);

/// Checks what is known of a body before it is read. Returns false after it has answered an error:
/// LENGTH_REQUIRED (neither Content-Length nor chunked; status 411), BODY_TOO_LARGE,
/// ENCODING_UNSUPPORTED.
bool admit_body(Exchange& exchange, std::uint64_t limit);

/// Admits a body of any length that is answered while it arrives. Returns false after it has
/// answered LENGTH_REQUIRED or ENCODING_UNSUPPORTED.
bool admit_stream(Exchange& exchange);

/// The error of a body that could not be read to its end: BODY_INCOMPLETE, ENCODING_BROKEN,
/// REQUEST_TIMEOUT (kDeadline), MEMORY_BUSY (kBusy) or SPOOL_UNREADABLE (kInternal). Null for
/// `body` gives BODY_INCOMPLETE.
Error body_fault(const BodyReader* body);
/// Answers with body_fault: status 400, 408 for a slow client, 503 or 500.
void reply_body_fault(Exchange& exchange);

/// True if all of the body, or more than the limit, has arrived. If false, the request is put off:
/// the handler must return, and is called again. Precondition: admit_body returned true.
bool is_body_here(const Exchange& exchange, std::uint64_t limit);

/// Passes the part of the body that has arrived to `sink`, decoded; the limit counts decoded bytes.
/// If the body is not complete, it stores `state` in BodyReader::kept, puts the request off and
/// returns false; the handler is called again for the next part. A body with a Content-Encoding
/// must be complete first: is_body_here. Also returns false after it has answered: BODY_TOO_LARGE,
/// BODY_INCOMPLETE (the client stopped, or broke the framing), or the error of `sink`.
/// Precondition: admit_body returned true, and `state` is not null.
bool read_body_in_parts(Exchange& exchange, std::uint64_t limit, std::shared_ptr<void> state,
                        const std::function<Status(std::span<const char>)>& sink);

/// Appends the whole body to `text`, and reserves the memory to parse it. `text` may hold the
/// beginning of the body already; it gets `spare` bytes of further capacity. Returns false if the
/// request was put off, or after it has answered an error, including 503 MEMORY_BUSY and 413
/// REQUEST_TOO_LARGE.
bool read_body(Exchange& exchange, std::uint64_t limit, std::size_t spare, std::string& text);
/// Reserves the memory to parse a body: 8 bytes for each of its bytes. `memory` may be null.
/// Errors: those of RequestMemory::reserve.
Status reserve_decoding(RequestMemory* memory, std::string_view body);
/// Frees `text` and the decoder after the body was parsed. Releases the reserved memory of the
/// request except for `bytes`.
void forget_body(Exchange& exchange, std::string& text, std::uint64_t bytes);

}  // namespace sightline

// Tests: tests/integration/errors_test.py
