#pragma once
/// The head of a request, read strictly: what two programs on the way could read in two ways
/// ([RFC9112] 2.2, 3.2, 5 and 6.3) is refused. Pure functions over bytes; they know no sockets.

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

struct HeadLimits {
  Live<std::size_t> bytes{16 << 10};  ///< of a whole head
  Live<std::size_t> fields{100};
};

/// Why a request is not taken. Both texts are literals.
struct RequestFault {
  int status = 400;
  const char* code = "";
  const char* detail = "";
};

/// Finds the end of a header in bytes that arrive piece by piece. It reads each byte once. A NUL,
/// and a CR or an LF without the other, is a fault at once.
class HeadScan {
 public:
  enum class State { kMore, kWhole, kFault };
  /// `bytes` begins where the head begins, and only ever grows.
  State look(std::string_view bytes, const HeadLimits& limits);
  /// Of the head with its empty line; when it is whole.
  std::size_t size() const { return at_; }
  const RequestFault& fault() const { return fault_; }
  /// Empty lines before the head, which [RFC9112] 2.2 says to forgive.
  std::size_t begin() const { return begin_; }

 private:
  State refuse(RequestFault fault);

  std::size_t at_ = 0;     ///< bytes seen
  std::size_t begin_ = 0;  ///< where the request line begins
  std::size_t line_ = 0;   ///< where the line that is being read begins
  bool has_line_ = false;
  RequestFault fault_;
};

/// Whether a text must not be repeated in an answer or a log; null: none.
using IsSecret = std::function<bool(std::string_view)>;

/// What a route needs, and what a caller may: each includes those before it.
enum class Access { kOpen, kRead, kWrite };

struct RequestHead {
  std::string method;
  std::string target;  ///< a path with its query, also where the client sent a whole URL
  bool http10 = false;
  std::optional<std::uint64_t> length;  ///< of the body, where it is said
  bool chunked = false;
  bool close = false;                  ///< the client wants no further request, or cannot have one
  bool expects_continue = false;       ///< it sends its body only after a 100
  std::string host;                    ///< of its field, with the port; empty in HTTP/1.0 perhaps
  std::string request_id;              ///< as it was sent: not checked
  Coding accepts = Coding::kIdentity;  ///< for the answer
  std::optional<Coding> coding = Coding::kIdentity;  ///< of the body; none: one that nobody knows
  std::optional<std::string> content_type;           ///< as it was sent, of two the first
  std::string accept;                                ///< the same
  std::string authorization;     ///< the same; empty also where there is more than one
  std::string origin;            ///< of the page that asks; "null" where there is more than one
  bool cross_site = false;       ///< Sec-Fetch-Site: a browser asks for another site
  bool asks_for_method = false;  ///< whether there is an Access-Control-Request-Method
  std::optional<std::string> if_match, if_none_match;  ///< of several one list [RFC9110] 5.3
  // The caller, by EventLoopCallbacks::admit.
  Access access = Access::kOpen;
  std::string key_name;
  bool hides_path = false;                    ///< the path holds a key: no log shows it
  std::shared_ptr<const CancelFlag> revoked;  ///< set when the key is one no more; null without

  bool has_body() const { return chunked || length.value_or(0) > 0; }
};

/// `text` is a whole header as HeadScan found it, from its request line to its empty line. After a
/// fault, only the request_id of `head` is valid, and the begin of the next request is unknown.
/// Faults:
/// - REQUEST_MALFORMED, URI_TOO_LONG (414), HEADER_TOO_LARGE (431), VERSION_UNSUPPORTED (505),
/// EXPECTATION_UNKNOWN (417)
/// - HOST_INVALID: not exactly one Host; HTTP/1.0 may omit it
/// - FRAMING_AMBIGUOUS: several values of Content-Length, or one that is not a number; a Transfer-
/// Encoding other than chunked, or beside a Content-Length, or in HTTP/1.0
std::optional<RequestFault> parse_request_head(std::string_view text, const HeadLimits& limits,
                                               RequestHead& head);

}  // namespace sightline
