#include "server/http/request_head.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "server/http/ascii.h"
#include "server/http/ip_address.h"

namespace sightline {
namespace {

/// What the library takes of a line, with room for the rest of the request line.
constexpr std::size_t kLongestLine = 8000;
constexpr std::size_t kLongestMethod = 32;
/// Empty lines before a request line: some clients send one after a body.
constexpr std::size_t kForgivenLines = 2;

constexpr RequestFault kMalformed{400, "REQUEST_MALFORMED",
                                  "this is not an HTTP/1.1 request that the server understands"};
constexpr RequestFault kLongTarget{414, "URI_TOO_LONG", "the request's path is too long"};
constexpr RequestFault kLargeHead{431, "HEADER_TOO_LARGE",
                                  "the request's header is larger than it may be"};
constexpr const char* kFraming = "FRAMING_AMBIGUOUS";

/// A set of characters.
class CharSet {
 public:
  template <class Contains>
  explicit constexpr CharSet(const Contains& contains) {
    for (std::size_t i = 0; i < has_.size(); ++i) has_[i] = contains(static_cast<char>(i));
  }
  bool has_all(std::string_view text) const {
    return std::all_of(text.begin(), text.end(),
                       [&](char c) { return has_[static_cast<unsigned char>(c)]; });
  }

 private:
  std::array<bool, 256> has_{};
};

constexpr bool is_one_of(char c, std::string_view set) {
  return set.find(c) != std::string_view::npos;
}

/// [RFC9110] 5.6.2
constexpr CharSet kToken([](char c) {
  return (c >= '0' && c <= '9') || (lower_case(c) >= 'a' && lower_case(c) <= 'z') ||
         is_one_of(c, "!#$%&'*+-.^_`|~");
});
bool is_token(std::string_view text) { return !text.empty() && kToken.has_all(text); }

/// Bytes above ASCII are let through: the router answers them like any other name it does not have.
constexpr bool is_visible(char c) {
  return (c > 0x20 && c != 0x7f) || static_cast<unsigned char>(c) >= 0x80;
}

/// [RFC9112] 3.2: no fragment. A reader that cuts one off would see another path than was judged.
constexpr CharSet kTarget([](char c) { return c != '#' && is_visible(c); });
bool is_target(std::string_view text) { return !text.empty() && kTarget.has_all(text); }

constexpr CharSet kFieldValue([](char c) { return c == ' ' || c == '\t' || is_visible(c); });

/// No list, no user, no path, nothing behind the port: what another program could take for another
/// host.
constexpr CharSet kHost([](char c) { return is_visible(c) && !is_one_of(c, ",/\\@?#\"<>"); });
bool is_host(std::string_view text) { return kHost.has_all(text) && host_name(text); }

/// Cuts the next line off, without its CR LF.
std::string_view next_line(std::string_view& text) {
  const std::size_t end = std::min(text.find("\r\n"), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 2, text.size()));
  return line;
}

/// Digits alone: no sign, no list, no blank.
std::optional<std::uint64_t> parse_length(std::string_view text) {
  std::uint64_t length = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, length);
  if (text.empty() || error != std::errc() || last != end) return std::nullopt;
  return length;
}

bool is_known(std::string_view method) {
  constexpr std::array<std::string_view, 9> kKnown{"GET",     "HEAD",    "POST",  "PUT",  "DELETE",
                                                   "CONNECT", "OPTIONS", "TRACE", "PATCH"};
  return std::find(kKnown.begin(), kKnown.end(), method) != kKnown.end();
}

/// "http://host/path" becomes "/path" [RFC9112] 3.2.2; there is only one host here, but it must be
/// one [RFC9110] 4.2.1.
std::optional<std::string> origin_form(std::string_view target) {
  constexpr std::string_view kScheme = "http://";
  if (!equals_caseless(target.substr(0, kScheme.size()), kScheme)) return std::string(target);
  target.remove_prefix(kScheme.size());
  const std::string_view host = target.substr(0, target.find_first_of("/?"));
  if (host.empty() || !is_host(host)) return std::nullopt;
  target.remove_prefix(host.size());
  return target.starts_with('/') ? std::string(target) : "/" + std::string(target);
}

std::optional<RequestFault> parse_request_line(std::string_view line, RequestHead& head) {
  if (line.size() > kLongestLine) return kLongTarget;
  const std::size_t first = line.find(' '), last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) return kMalformed;
  head.method = line.substr(0, first);
  const std::string_view target = line.substr(first + 1, last - first - 1);
  const std::string_view version = line.substr(last + 1);
  if (!is_token(head.method) || head.method.size() > kLongestMethod || !is_target(target) ||
      !version.starts_with("HTTP/")) {
    return kMalformed;
  }
  head.http10 = version == "HTTP/1.0";
  if (!head.http10 && version != "HTTP/1.1") {
    return RequestFault{505, "VERSION_UNSUPPORTED", "the versions here are HTTP/1.1 and HTTP/1.0"};
  }
  std::optional<std::string> origin = origin_form(target);
  if (!origin) return kMalformed;
  head.target = std::move(*origin);
  return std::nullopt;
}

/// What the fields of a head said, counted.
struct Fields {
  std::size_t count = 0, hosts = 0, lengths = 0, encodings = 0, authorizations = 0, origins = 0,
              request_ids = 0, codings = 0, accepts = 0;
};

/// Whether a list of preferences [RFC7240] has one of this name, whatever its value.
bool has_preference(std::string_view list, std::string_view lower) {
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(','), list.size());
    std::string_view name = list.substr(0, end);
    name = name.substr(0, name.find(';'));
    if (equals_caseless(trimmed(name), lower)) return true;
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return false;
}

void take_connection(std::string_view list, RequestHead& head) {
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(','), list.size());
    const std::string_view option = trimmed(list.substr(0, end));
    if (equals_caseless(option, "close")) head.close = true;
    list.remove_prefix(std::min(end + 1, list.size()));
  }
}

std::optional<RequestFault> take_framing(std::string_view name, std::string_view value,
                                         RequestHead& head, Fields& fields) {
  if (equals_caseless(name, "content-length")) {
    ++fields.lengths;
    head.length = parse_length(value);
    if (!head.length) {
      return RequestFault{400, kFraming, "Content-Length is not a number of bytes"};
    }
  } else if (equals_caseless(name, "transfer-encoding")) {
    ++fields.encodings;
    head.chunked = equals_caseless(value, "chunked");
    if (!head.chunked || head.http10) {
      return RequestFault{400, kFraming,
                          "the only Transfer-Encoding here is chunked, and only in HTTP/1.1"};
    }
  }
  if (fields.lengths + fields.encodings > 1) {
    return RequestFault{400, kFraming,
                        "send one Content-Length or one Transfer-Encoding, and not both"};
  }
  return std::nullopt;
}

void add_to_list(std::optional<std::string>& list, std::string_view value) {
  if (list) {
    list->append(", ").append(value);
  } else {
    list = value;
  }
}

std::optional<RequestFault> take_field(std::string_view line, RequestHead& head, Fields& fields) {
  if (line.size() > kLongestLine) return kLargeHead;
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos) return kMalformed;
  const std::string_view name = line.substr(0, colon);
  const std::string_view value = trimmed(line.substr(colon + 1));
  // A blank before the colon, and a line that goes on from the last one, are no tokens.
  if (!is_token(name) || !kFieldValue.has_all(value)) return kMalformed;
  if (equals_caseless(name, "host")) {
    if (++fields.hosts > 1 || !is_host(value)) {
      return RequestFault{400, "HOST_INVALID", "a request needs exactly one Host header"};
    }
    head.host = value;
  } else if (equals_caseless(name, "connection")) {
    take_connection(value, head);
  } else if (equals_caseless(name, "x-request-id")) {
    // Of two none: a log that knows another one than the client would mislead.
    head.request_id = ++fields.request_ids == 1 ? value : "";
  } else if (equals_caseless(name, "authorization")) {
    head.authorization = ++fields.authorizations == 1 ? value : "";
  } else if (equals_caseless(name, "origin")) {
    head.origin = ++fields.origins == 1 ? value : "null";
  } else if (equals_caseless(name, "sec-fetch-site")) {
    head.cross_site = head.cross_site || equals_caseless(value, "cross-site");
  } else if (equals_caseless(name, "access-control-request-method")) {
    head.asks_for_method = true;
  } else if (equals_caseless(name, "expect")) {
    if (!equals_caseless(value, "100-continue")) {
      return RequestFault{417, "EXPECTATION_UNKNOWN", "the only Expect here is 100-continue"};
    }
    head.expects_continue = !head.http10;
  } else if (equals_caseless(name, "accept-encoding")) {
    head.accepts = choose_coding(value);
  } else if (equals_caseless(name, "content-encoding")) {
    head.coding = ++fields.codings == 1 ? find_coding(value) : std::nullopt;
  } else if (equals_caseless(name, "content-type")) {
    if (!head.content_type) head.content_type = value;
  } else if (equals_caseless(name, "prefer")) {
    head.prefers_async = head.prefers_async || has_preference(value, "respond-async");
  } else if (equals_caseless(name, "accept")) {
    if (++fields.accepts == 1) head.accept = value;
  } else if (equals_caseless(name, "if-match")) {
    add_to_list(head.if_match, value);
  } else if (equals_caseless(name, "if-none-match")) {
    add_to_list(head.if_none_match, value);
  } else if (equals_caseless(name, "x-scene-min-revision")) {
    if (!head.min_revision) head.min_revision = value;
  } else {
    return take_framing(name, value, head, fields);
  }
  return std::nullopt;
}

/// Bytes of the first line with its CR LF; 0 where it is not all here, empty, too long, or has
/// bytes that must be checked one by one.
std::size_t plain_line(std::string_view bytes) {
  const std::size_t end = bytes.find('\r');
  if (end == 0 || end > kLongestLine || bytes.size() - end < 2 || bytes[end + 1] != '\n') return 0;
  const std::string_view line = bytes.substr(0, end);
  return line.find('\0') == line.npos && line.find('\n') == line.npos ? end + 2 : 0;
}

}  // namespace

HeadScan::State HeadScan::refuse(RequestFault fault) {
  fault_ = fault;
  return State::kFault;
}

HeadScan::State HeadScan::look(std::string_view bytes, const HeadLimits& limits) {
  const std::size_t most = limits.bytes;
  while (at_ < bytes.size()) {
    // A line that is here and in order needs no check of each byte.
    if (const std::size_t line = at_ == line_ ? plain_line(bytes.substr(at_)) : 0;
        line > 0 && at_ + line - begin_ <= most) {
      at_ = line_ = at_ + line;
      has_line_ = true;
      continue;
    }
    const char c = bytes[at_];
    const bool after_cr = at_ > begin_ && bytes[at_ - 1] == '\r';
    if (c == '\0' || (c == '\n') != after_cr) {
      return refuse(
          {400, "REQUEST_MALFORMED", "a header has lines that end with CR LF, and no NUL"});
    }
    ++at_;
    // Byte by byte, so that no fault depends on how many of them came at once.
    if (at_ - begin_ > most) return refuse(kLargeHead);
    if (at_ - line_ > kLongestLine + 2) return refuse(has_line_ ? kLargeHead : kLongTarget);
    if (c != '\n') continue;
    const bool is_empty = at_ - line_ == 2;
    line_ = at_;
    if (!is_empty) {
      has_line_ = true;
    } else if (has_line_) {
      return State::kWhole;
    } else {
      begin_ = at_;
      if (begin_ > 2 * kForgivenLines) return refuse(kMalformed);
    }
  }
  return State::kMore;
}

std::optional<RequestFault> parse_request_head(std::string_view text, const HeadLimits& limits,
                                               RequestHead& head) {
  head = {};
  if (text.size() > limits.bytes) return kLargeHead;
  Fields fields;
  if (auto fault = parse_request_line(next_line(text), head)) return fault;
  while (!text.empty()) {
    const std::string_view line = next_line(text);
    if (line.empty()) break;
    if (++fields.count > limits.fields) return kLargeHead;
    if (auto fault = take_field(line, head, fields)) return fault;
  }
  if (fields.hosts == 0 && !head.http10) {
    return RequestFault{400, "HOST_INVALID", "a request needs exactly one Host header"};
  }
  // HTTP/1.0 would not know where a stream ends on a connection that stays open; and of a method
  // that nobody knows nobody knows what follows.
  head.close = head.close || head.http10 || !is_known(head.method);
  return std::nullopt;
}

}  // namespace sightline
