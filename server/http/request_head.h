#pragma once
/// Parses the head of a request strictly: what two programs could read in two ways ([RFC9112] 2.2,
/// 3.2, 5 and 6.3) is refused. Pure functions over bytes, without sockets.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/deadline.h"
#include "core/base/live.h"
#include "server/http/content_coding.h"

namespace sightline {

/// Limits of the head of a request; Live, so they may change while the server runs.
struct HeadLimits {
  Live<std::size_t> bytes{16 << 10};  ///< size of a whole head
  /// Number of header fields.
  Live<std::size_t> fields{100};
};

/// Why a request is refused. Both texts are literals.
struct RequestFault {
  int status = 400;
  const char* code = "";
  const char* detail = "";
};

/// Finds the end of a head in bytes that arrive piece by piece, reading each byte once. A NUL, and
/// a CR or LF without the other, is a fault at once.
class HeadScan {
 public:
  enum class State { kMore, kWhole, kFault };
  /// Examines new bytes. `bytes` begins where the head begins, and only grows from call to call. No
  /// call may follow after kWhole or kFault.
  State look(std::string_view bytes, const HeadLimits& limits);
  /// Size of the head with its empty line, in state kWhole.
  std::size_t size() const { return at_; }
  /// Why the head is refused, in state kFault.
  const RequestFault& fault() const { return fault_; }
  /// Size of the empty lines before the head, which [RFC9112] 2.2 allows.
  std::size_t begin() const { return begin_; }

 private:
  State refuse(RequestFault fault);

  std::size_t at_ = 0;     ///< bytes examined
  std::size_t begin_ = 0;  ///< beginning of the request line
  std::size_t line_ = 0;   ///< beginning of the present line
  bool has_line_ = false;
  RequestFault fault_;
};

/// True if a text must not be repeated in an answer or a log. A null function: never. Called on
/// several threads at once.
using IsSecret = std::function<bool(std::string_view)>;

/// The access that a route needs or a key has. Each level includes the levels before it.
enum class Access { kOpen, kRead, kWrite };

/// A parsed head.
struct RequestHead {
  std::string method;
  std::string target;  ///< path and query, also if the client sent a whole URL
  bool http10 = false;
  std::optional<std::uint64_t> length;  ///< of the body, if stated
  bool chunked = false;
  bool close = false;                  ///< the connection ends after this request
  bool expects_continue = false;       ///< the client sends its body only after a 100
  std::string host;                    ///< value of Host, with the port; may be empty in HTTP/1.0
  std::string request_id;              ///< as sent, not validated
  Coding accepts = Coding::kIdentity;  ///< preferred coding of the answer
  std::optional<Coding> coding = Coding::kIdentity;  ///< coding of the body; empty: unknown
  std::optional<std::string> content_type;           ///< as sent; the first of several
  std::string accept;                                ///< as sent; the first of several
  bool prefers_async = false;                        ///< Prefer: respond-async [RFC7240]
  std::string authorization;                         ///< as sent; empty if there is more than one
  std::string origin;       ///< origin of the requesting page; "null" if there is more than one
  bool cross_site = false;  ///< Sec-Fetch-Site: a page of another site makes the request
  bool asks_for_method = false;  ///< there is an Access-Control-Request-Method
  /// several fields are joined to one list [RFC9110] 5.3
  std::optional<std::string> if_match, if_none_match;
  /// X-Scene-Min-Revision, as sent; the first of several
  std::optional<std::string> min_revision;
  // The client, set by EventLoopCallbacks::admit.
  Access access = Access::kOpen;
  std::string key_name;
  bool hides_path = false;                    ///< the path contains a key, so it is not logged
  std::shared_ptr<const CancelFlag> revoked;  ///< set when the key is revoked; null without a key

  bool has_body() const { return chunked || length.value_or(0) > 0; }
};

/// Parses a whole head as HeadScan found it, from the request line to the empty line. After a
/// fault, only the request_id of `head` is valid, and the beginning of the next request is unknown.
/// Faults:
/// - REQUEST_MALFORMED, URI_TOO_LONG (414), HEADER_TOO_LARGE (431), VERSION_UNSUPPORTED (505),
///   EXPECTATION_UNKNOWN (417)
/// - HOST_INVALID: not exactly one Host; HTTP/1.0 may omit it
/// - FRAMING_AMBIGUOUS: several values of Content-Length, or one that is not a number; a
///   Transfer-Encoding other than chunked, or with a Content-Length, or in HTTP/1.0
std::optional<RequestFault> parse_request_head(std::string_view text, const HeadLimits& limits,
                                               RequestHead& head);

}  // namespace sightline
