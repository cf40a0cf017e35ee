#include "server/exchange.h"

#include <openssl/rand.h>

#include <array>
#include <utility>

#include "core/store/scene_id.h"
#include "server/http_status.h"

namespace sightline {

void Exchange::reply(int status, std::string content, std::string_view media_type) {
  response.status = status;
  response.body = std::move(content);
  // set_header adds: an earlier answer of this exchange must leave nothing behind.
  response.headers.erase("Content-Type");
  response.set_header("Content-Type", std::string(media_type));
  response.headers.erase("X-Request-Id");
  response.set_header("X-Request-Id", request_id);
}

void Exchange::reply_empty(int status) {
  response.status = status;
  response.body.clear();
  response.headers.erase("X-Request-Id");
  response.set_header("X-Request-Id", request_id);
}

void Exchange::reply_problem(Problem problem) {
  problem.request_id = request_id;
  const int status = problem.status;
  reply(status, encode_problem(problem), kProblemMediaType);
}

void Exchange::reply_problem(int status, std::string_view code, std::string detail) {
  Problem problem;
  problem.status = status;
  problem.title = status_title(status);
  problem.detail = std::move(detail);
  problem.code = code;
  reply_problem(std::move(problem));
}

void Exchange::reply_error(const Error& error) {
  const int status = http_status(error.kind);
  reply_problem(make_problem(error, status, status_title(status)));
}

std::string request_id_of(const httplib::Request& request) {
  std::string given = request.get_header_value("X-Request-Id");
  // The same alphabet as a scene's name: safe in a header and in a log.
  if (is_scene_id(given)) return given;
  std::array<unsigned char, 8> bytes{};
  (void)RAND_bytes(bytes.data(), static_cast<int>(bytes.size()));
  constexpr char kDigits[] = "0123456789abcdef";
  std::string id;
  for (const unsigned char byte : bytes) {
    id += kDigits[byte >> 4];
    id += kDigits[byte & 15u];
  }
  return id;
}

}  // namespace sightline
