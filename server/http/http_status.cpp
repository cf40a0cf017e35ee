#include "server/http/http_status.h"

#include <algorithm>
#include <array>
#include <utility>

namespace sightline {
namespace {

constexpr auto kTitles =
    std::to_array<std::pair<int, std::string_view>>({{200, "OK"},
                                                     {201, "Created"},
                                                     {202, "Accepted"},
                                                     {204, "No Content"},
                                                     {304, "Not Modified"},
                                                     {400, "Bad Request"},
                                                     {401, "Unauthorized"},
                                                     {403, "Forbidden"},
                                                     {404, "Not Found"},
                                                     {405, "Method Not Allowed"},
                                                     {408, "Request Timeout"},
                                                     {409, "Conflict"},
                                                     {411, "Length Required"},
                                                     {412, "Precondition Failed"},
                                                     {413, "Payload Too Large"},
                                                     {414, "URI Too Long"},
                                                     {415, "Unsupported Media Type"},
                                                     {416, "Range Not Satisfiable"},
                                                     {417, "Expectation Failed"},
                                                     {422, "Unprocessable Entity"},
                                                     {431, "Request Header Fields Too Large"},
                                                     {503, "Service Unavailable"},
                                                     {504, "Gateway Timeout"},
                                                     {505, "HTTP Version Not Supported"},
                                                     {507, "Insufficient Storage"}});

}  // namespace

int http_status(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kInvalid:
      return 422;
    case ErrorKind::kMalformed:
      return 400;
    case ErrorKind::kUnsupported:
      return 415;
    case ErrorKind::kTooLarge:
      return 413;
    case ErrorKind::kNotFound:
      return 404;
    case ErrorKind::kConflict:
      return 409;
    case ErrorKind::kPrecondition:
      return 412;
    case ErrorKind::kCancelled:
    case ErrorKind::kBusy:
      return 503;
    case ErrorKind::kDeadline:
      return 504;
    case ErrorKind::kOutOfSpace:
      return 507;
    case ErrorKind::kInternal:
      return 500;
  }
  return 500;
}

std::string_view status_title(int status) {
  const auto found = std::find_if(kTitles.begin(), kTitles.end(),
                                  [&](const auto& each) { return each.first == status; });
  if (found != kTitles.end()) return found->second;
  return status >= 500 ? "Internal Server Error" : "Error";
}

}  // namespace sightline
