#include "server/http/exchange.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <utility>

#include "core/base/plain_name.h"
#include "core/base/split_mix.h"
#include "server/http/ascii.h"
#include "server/http/body_reader.h"
#include "server/http/http_status.h"
#include "server/http/request_memory.h"

namespace sightline {

bool Exchange::wants(std::string_view media_type) const {
  const std::string_view accepted = head.accept;
  return equals_caseless(trimmed(accepted.substr(0, accepted.find_first_of(",;"))), media_type);
}

Status Exchange::reserve(std::uint64_t bytes) const { return sightline::reserve(memory, bytes); }

bool Exchange::is_put_off() const {
  if (body != nullptr && body->is_put_off()) return true;
  if (may_repeat && response.status == 503 && memory != nullptr && memory->was_refused()) {
    return true;
  }
  // Want of time, of memory or of trees: a worker has them.
  return on_event_loop && (response.status == 0 || response.status >= 500);
}

void Exchange::reply(int status, std::string content, std::string_view media_type) {
  response.status = status;
  response.body = std::move(content);
  response.content_type = media_type;
}

void Exchange::reply_empty(int status) {
  response.status = status;
  response.body.clear();
}

void Exchange::reply_stream(std::string_view media_type,
                            std::function<bool(const Send& send)> next) {
  reply_empty(200);
  streams = true;
  response.content_type = media_type;
  // Events are small and wanted at once; numbers hardly shrink.
  const Coding accepts = head.accepts;
  if (accepts == Coding::kIdentity || media_type != "application/x-ndjson") {
    response.stream = std::move(next);
    return;
  }
  const auto encoder = std::make_shared<ContentEncoder>(accepts);
  response.set_header("Content-Encoding", std::string(coding_name(accepts)));
  response.set_header("Vary", "Accept-Encoding");
  response.stream = [next = std::move(next), encoder](const Send& send) {
    bool good = true;
    const bool goes_on = next([&](std::string_view text) {
      good = send(encoder->encode(text, false));
      return good;
    });
    if (!goes_on && good) send(encoder->encode("", true));
    return goes_on;
  };
}

void Exchange::reply_problem(Problem problem) {
  problem.request_id = request_id;
  problem_code = problem.code;
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
  reply_problem(make_problem(error, status, std::string(status_title(status))));
  if (error.kind == ErrorKind::kBusy) response.set_header("Retry-After", "1");
}

std::string checked_request_id(const std::string& given, const IsSecret& is_secret) {
  if (is_plain_name(given) && !(is_secret && is_secret(given))) return given;
  // It has to differ, not to be a secret, and random bytes of the system would cost a tenth of a
  // trivial request: two requests at one moment are on two stacks.
  std::string id(16, '0');
  const auto moment =
      static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
  std::uint64_t bits = scramble(moment ^ scramble(reinterpret_cast<std::uintptr_t>(&id)));
  constexpr char kDigits[] = "0123456789abcdef";
  for (char& digit : id) {
    digit = kDigits[bits & 15u];
    bits >>= 4;
  }
  return id;
}

}  // namespace sightline
