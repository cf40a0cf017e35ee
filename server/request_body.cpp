#include "server/request_body.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include "server/body_reader.h"
#include "server/work_memory.h"

namespace sightline {
namespace {

/// What a ray of 40 bytes of JSON takes at most as columns, hit, details and JSON again.
constexpr std::uint64_t kWorkPerByte = 8;

bool is_chunked(const httplib::Request& request) { return request.has_header("Transfer-Encoding"); }

std::optional<std::uint64_t> content_length(const httplib::Request& request) {
  const std::string text = request.get_header_value("Content-Length");
  std::uint64_t length = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), length);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return length;
}

void reply_too_large(Exchange& exchange, std::uint64_t limit) {
  exchange.reply_problem(413, "BODY_TOO_LARGE",
                         "the body may have " + std::to_string(limit) + " bytes");
}

}  // namespace

std::optional<std::uint64_t> body_length(const Exchange& exchange) {
  return content_length(exchange.request);
}

bool admit_body(Exchange& exchange, std::uint64_t limit) {
  const std::string encoding = exchange.request.get_header_value("Content-Encoding");
  if (!encoding.empty() && encoding != "identity") {
    exchange.reply_problem(415, "ENCODING_UNSUPPORTED", "send the body without Content-Encoding");
    return false;
  }
  if (is_chunked(exchange.request)) return true;
  const auto length = content_length(exchange.request);
  if (!length) {
    exchange.reply_problem(411, "LENGTH_REQUIRED", "send Content-Length, or a chunked body");
    return false;
  }
  if (*length > limit) {
    reply_too_large(exchange, limit);
    return false;
  }
  return true;
}

namespace {

/// The media type without its parameters, in lower case.
std::string media_type(const Exchange& exchange) {
  std::string type = exchange.request.get_header_value("Content-Type");
  type.resize(std::min(type.find(';'), type.size()));
  while (!type.empty() && type.back() == ' ') type.pop_back();
  std::transform(type.begin(), type.end(), type.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return type;
}

}  // namespace

bool admit_media_type(Exchange& exchange, std::initializer_list<std::string_view> accepted,
                      std::initializer_list<std::string_view> tolerated) {
  if (!exchange.request.has_header("Content-Type")) return true;
  const std::string type = media_type(exchange);
  std::string list;
  for (const std::string_view each : accepted) {
    if (type == each) return true;
    list += (list.empty() ? "" : " or ") + std::string(each);
  }
  if (std::find(tolerated.begin(), tolerated.end(), type) != tolerated.end()) return true;
  exchange.reply_problem(415, "MEDIA_TYPE_UNSUPPORTED", "send Content-Type: " + list);
  return false;
}

bool admit_query_type(Exchange& exchange) {
  return admit_media_type(exchange, {"application/json"}, {kFormMediaType});
}

std::optional<QueryType> admit_rays_type(Exchange& exchange) {
  constexpr std::string_view kBinary = "application/octet-stream";
  if (!admit_media_type(exchange, {"application/json", kBinary}, {kFormMediaType})) {
    return std::nullopt;
  }
  return media_type(exchange) == kBinary ? QueryType::kBinary : QueryType::kJson;
}

bool read_body(Exchange& exchange, std::uint64_t limit,
               const std::function<Status(std::span<const char>)>& sink) {
  std::uint64_t size = 0;
  bool too_large = false;
  std::optional<Error> refused;
  const auto receive = [&](std::span<const char> piece) {
    size += piece.size();
    too_large = size > limit;
    if (too_large) return false;
    Status status = sink(piece);
    if (!status) refused = std::move(status).error();
    return !refused;
  };
  if (exchange.body != nullptr && exchange.body->read(receive)) return true;
  if (too_large) {
    reply_too_large(exchange, limit);
  } else if (refused) {
    exchange.reply_error(*refused);
  } else if (exchange.body != nullptr && exchange.body->fault() == BodyReader::Fault::kSlow) {
    exchange.reply_problem(408, "REQUEST_TIMEOUT", "the body of the request came too slowly");
  } else {
    exchange.reply_problem(400, "BODY_INCOMPLETE", "the body ended early or its framing is broken");
  }
  return false;
}

bool read_body(Exchange& exchange, std::uint64_t limit, std::size_t spare, std::string& text) {
  if (const auto length = content_length(exchange.request)) {
    // Room for what was promised, but no more than 1 MiB before it has come.
    text.reserve(std::min<std::uint64_t>(*length, 1u << 20) + spare);
  }
  const Error busy{ErrorKind::kBusy, "MEMORY_BUSY",
                   "large requests use all the memory that they may: ask again later", ""};
  RequestMemory* memory = exchange.memory;
  const bool good = read_body(exchange, limit, [&](std::span<const char> piece) -> Status {
    if (memory != nullptr && !memory->body.grow(piece.size())) return busy;
    text.append(piece.data(), piece.size());
    return success();
  });
  if (!good || memory == nullptr) return good;
  const Deadline deadline = Deadline::in(memory->patience, exchange.caller);
  if (memory->work.wait(text.size() * kWorkPerByte, deadline)) return true;
  exchange.reply_error(busy);
  return false;
}

}  // namespace sightline
