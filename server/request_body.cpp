#include "server/request_body.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include "proto/hit_lines.h"
#include "proto/ray_binary.h"
#include "server/body_reader.h"
#include "server/work_memory.h"

namespace sightline {
namespace {

/// What a parser takes, and what comes out of it: of a ray of 40 bytes 64.
constexpr std::uint64_t kWorkPerByte = 8;
constexpr std::uint64_t kShortBody = 64 << 10;

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

bool admit_stream(Exchange& exchange) {
  const auto coding = find_coding(exchange.request.get_header_value("Content-Encoding"));
  if (!coding || exchange.request.get_header_value_count("Content-Encoding") > 1) {
    exchange.response.set_header("Accept-Encoding", "gzip, zstd");
    exchange.reply_problem(415, "ENCODING_UNSUPPORTED",
                           "send the body in gzip, in zstd, or without Content-Encoding");
    return false;
  }
  if (!is_chunked(exchange.request) && !content_length(exchange.request)) {
    exchange.reply_problem(411, "LENGTH_REQUIRED", "send Content-Length, or a chunked body");
    return false;
  }
  if (exchange.body != nullptr) exchange.body->decode_as(*coding);
  return true;
}

bool admit_body(Exchange& exchange, std::uint64_t limit) {
  if (!admit_stream(exchange)) return false;
  if (content_length(exchange.request).value_or(0) <= limit) return true;
  reply_too_large(exchange, limit);
  return false;
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

std::optional<QueryType> admit_rays_type(Exchange& exchange, bool takes_lines) {
  const bool good =
      takes_lines
          ? admit_media_type(exchange, {"application/json", kLinesMediaType, kBinaryMediaType},
                             {kFormMediaType})
          : admit_media_type(exchange, {"application/json", kBinaryMediaType}, {kFormMediaType});
  if (!good) return std::nullopt;
  const std::string type = media_type(exchange);
  if (type == kBinaryMediaType) return QueryType::kBinary;
  return type == kLinesMediaType ? QueryType::kLines : QueryType::kJson;
}

Error body_fault(const BodyReader* body) {
  const auto fault = body == nullptr ? BodyReader::Fault::kEnded : body->fault();
  if (fault == BodyReader::Fault::kSlow) {
    return {ErrorKind::kDeadline, "REQUEST_TIMEOUT", "the body of the request came too slowly", ""};
  }
  if (fault == BodyReader::Fault::kCoding) {
    return {ErrorKind::kMalformed, "ENCODING_BROKEN",
            "the body is not what its Content-Encoding says, or ends too early", ""};
  }
  return {ErrorKind::kMalformed, "BODY_INCOMPLETE", "the body ended early or its framing is broken",
          ""};
}

void reply_body_fault(Exchange& exchange) {
  const Error error = body_fault(exchange.body);
  exchange.reply_problem(error.kind == ErrorKind::kDeadline ? 408 : 400, error.code, error.message);
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
  } else {
    reply_body_fault(exchange);
  }
  return false;
}

bool read_body(Exchange& exchange, std::uint64_t limit, std::size_t spare, std::string& text) {
  const auto length = content_length(exchange.request);
  // Room for what was promised, but no more than 1 MiB before it has come.
  if (length) text.reserve(std::min<std::uint64_t>(*length, 1u << 20) + spare);
  // Short ones are few bytes for each worker.
  const bool is_short =
      length && *length <= kShortBody && (exchange.body == nullptr || !exchange.body->decodes());
  RequestMemory* const memory = is_short ? nullptr : exchange.memory;
  if (text.size() > limit) {
    reply_too_large(exchange, limit);
    return false;
  }
  const bool good =
      read_body(exchange, limit - text.size(), [&](std::span<const char> piece) -> Status {
        if (memory != nullptr) {
          if (Status status = memory->body.grow(piece.size()); !status) return status;
        }
        text.append(piece.data(), piece.size());
        return success();
      });
  if (!good) return false;
  Status status = reserve_decoding(exchange.memory, text);
  if (!status) exchange.reply_error(status.error());
  return status.ok();
}

Status reserve_decoding(RequestMemory* memory, std::string_view body) {
  return reserve(memory, body.size() * kWorkPerByte);
}

void forget_body(Exchange& exchange, std::string& text, std::uint64_t bytes) {
  std::string().swap(text);
  if (exchange.memory == nullptr) return;
  exchange.memory->body.keep(0);
  exchange.memory->keep(bytes);
}

}  // namespace sightline
