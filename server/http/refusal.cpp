#include "server/http/refusal.h"

#include "proto/problem.h"
#include "server/http/http_status.h"

namespace sightline {

std::string refusal_text(const RequestFault& fault, const std::string& request_id,
                         std::string_view headers, bool with_body) {
  Problem problem;
  problem.status = fault.status;
  problem.title = status_title(fault.status);
  problem.detail = fault.detail;
  problem.code = fault.code;
  problem.request_id = request_id;
  const std::string body = encode_problem(problem);
  std::string text = "HTTP/1.1 " + std::to_string(fault.status) + " " + problem.title +
                     "\r\nContent-Type: " + std::string(kProblemMediaType) +
                     "\r\nX-Request-Id: " + problem.request_id +
                     "\r\nConnection: close\r\nContent-Length: " + std::to_string(body.size()) +
                     "\r\n" + std::string(headers);
  if (fault.status == 503) text += "Retry-After: 1\r\n";
  if (fault.status == 401) text += "WWW-Authenticate: Bearer realm=\"sightline\"\r\n";
  return text + "\r\n" + (with_body ? body : "");
}

}  // namespace sightline
