#include "server/http/response_writer.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <utility>

#include "proto/problem.h"
#include "server/http/http_status.h"

namespace sightline {
namespace {

constexpr std::size_t kCollected = 16 << 10;
/// What every connection may leave behind in memory, whatever others hold; and what it may where
/// the budget has room.
constexpr std::size_t kFreeOutput = 4 << 10, kMostOutput = 64 << 10;

bool wait_for(int socket, short events, std::chrono::steady_clock::time_point due) {
  for (;;) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(due - std::chrono::steady_clock::now());
    pollfd wanted{socket, events, 0};
    const int ready =
        ::poll(&wanted, 1, static_cast<int>(std::clamp<long long>(left.count(), 0, 3'600'000)));
    if (ready < 0 && errno == EINTR) continue;
    return ready > 0;
  }
}

void append_number(std::string& out, std::uint64_t value, int base) {
  std::array<char, 20> digits;
  const auto [end, error] =
      std::to_chars(digits.data(), digits.data() + digits.size(), value, base);
  out.append(digits.data(), end);
}

}  // namespace

bool wait_until_readable(int socket, std::chrono::steady_clock::time_point due) {
  return wait_for(socket, POLLIN, due);
}

void append_head(std::string& out, const RequestHead& head, const HttpResponse& response,
                 std::string_view request_id, bool is_last, const AnswerHeaders& headers) {
  // Most answers fit, with a short body.
  constexpr std::size_t kUsual = 1024;
  out.reserve(out.size() + kUsual);
  constexpr std::string_view kVersion = "HTTP/1.1 ", kColon = ": ", kEnd = "\r\n";
  out.append(kVersion);
  append_number(out, static_cast<std::uint64_t>(response.status), 10);
  out.append(1, ' ').append(status_title(response.status)).append(kEnd);
  const auto add = [&](std::string_view name, std::string_view value) {
    out.append(name).append(kColon).append(value).append(kEnd);
  };
  if (!response.content_type.empty()) add("Content-Type", response.content_type);
  for (const auto& [name, value] : response.headers) add(name, value);
  if (response.stream) {
    if (!head.http10) add("Transfer-Encoding", "chunked");
  } else if (response.status != 204 && response.status != 304) {  // [RFC9110] 8.6
    constexpr std::string_view kLength = "Content-Length: ";
    out.append(kLength);
    append_number(out, response.body.size(), 10);
    out.append(kEnd);
  }
  if (is_last) add("Connection", "close");
  add("X-Request-Id", request_id);
  headers.append_to(out, head, response);
  out.append(kEnd);
}

HttpResponse refusal(const RequestFault& fault, const std::string& request_id) {
  Problem problem;
  problem.status = fault.status;
  problem.title = status_title(fault.status);
  problem.detail = fault.detail;
  problem.code = fault.code;
  problem.request_id = request_id;
  HttpResponse response{fault.status, encode_problem(problem), kProblemMediaType};
  if (fault.status == 503) response.set_header("Retry-After", "1");
  if (fault.status == 401) response.set_header("WWW-Authenticate", "Bearer realm=\"sightline\"");
  return response;
}

bool ResponseWriter::send_with(std::string_view& more) {
  while (connection_.pending_output() > 0 || !more.empty()) {
    const std::size_t before = connection_.pending_output();
    iovec parts[2] = {{connection_.output.data() + connection_.sent, before},
                      {const_cast<char*>(more.data()), more.size()}};
    msghdr message{};
    message.msg_iov = parts;
    message.msg_iovlen = 2;
    const ssize_t count = ::sendmsg(connection_.socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return true;
    if (count <= 0) return false;
    const auto sent = static_cast<std::size_t>(count);
    connection_.given += sent;
    connection_.sent += std::min(sent, before);
    more.remove_prefix(sent - std::min(sent, before));
  }
  return true;
}

bool ResponseWriter::spool(std::string_view rest) {
  if (!connection_.output_file) {
    connection_.output_file = std::make_unique<SpoolFile>(connection_.spool);
  }
  SpoolFile& file = *connection_.output_file;
  // The output is sent before the file: it is empty from the file's first byte on.
  if (!file.append(std::string_view(connection_.output).substr(connection_.sent))) {
    if (file.size() == 0) connection_.output_file.reset();
    return false;
  }
  std::string().swap(connection_.output);
  connection_.sent = 0;
  return file.append(rest);
}

bool ResponseWriter::leave_behind(std::string_view rest) {
  const std::size_t size = connection_.pending_output() + rest.size();
  const auto fits = [&] {
    if (size <= kFreeOutput || size <= connection_.charged) return true;
    if (!connection_.budget.charge(size - connection_.charged)) return false;
    connection_.charged = size;
    return true;
  };
  if (!connection_.output_file) {
    // Where the spool is full, memory may do.
    const bool stays = size <= kMostOutput && fits();
    if (!stays && spool(rest)) return true;
    if (!stays && (connection_.output_file || !fits())) return false;
    connection_.output.erase(0, connection_.sent);
    connection_.sent = 0;
    connection_.output.append(rest);
    return true;
  }
  return spool(rest);
}

void ResponseWriter::Uptake::look(const Connection& connection) {
  const std::uint64_t before = std::exchange(taken, taken_by_client(connection));
  const Pace::Clock::time_point now = Pace::Clock::now();
  pace.moved(taken - before, now);
  busy_pace.moved(taken - before, now);
}

bool ResponseWriter::wait_for_client(Uptake& uptake) {
  while (!connection_.gone.cancelled()) {
    uptake.look(connection_);
    const Pace::Clock::time_point now = Pace::Clock::now();
    const auto due = uptake.pace.due();
    if (now >= uptake.busy_pace.due() && memory_.keeps_others_waiting()) return false;
    if (wait_for(connection_.socket, POLLOUT, std::min(due, now + kSlowClientLook))) return true;
    if (now >= due) return false;
  }
  return false;
}

void ResponseWriter::write(std::string_view text) {
  if (broken_) return;
  if (connection_.output_file) {
    broken_ = !spool(text);
    return;
  }
  if (connection_.pending_output() + text.size() <= kCollected) {
    connection_.output.append(text);
    return;
  }
  broken_ = !send_with(text);
  if (!broken_ && text.empty()) {
    connection_.output.clear();
    connection_.sent = 0;
  } else if (!broken_ && !connection_.streams) {
    broken_ = !leave_behind(text);
  } else if (!broken_) {
    Uptake uptake(connection_, pace_limits_, busy_limits_);
    while (!text.empty() && !broken_) broken_ = !wait_for_client(uptake) || !send_with(text);
  }
}

void ResponseWriter::write_stream(const HttpResponse& response, bool chunked) {
  const HttpResponse::Send send = [&](std::string_view piece) {
    if (piece.empty()) return !broken_;
    std::string size;
    if (chunked) {
      append_number(size, piece.size(), 16);
      write(size.append("\r\n"));
    }
    write(piece);
    if (chunked) write("\r\n");
    // It leaves now, not when the buffer is full.
    return flush();
  };
  while (!broken_ && response.stream(send)) {
  }
  if (chunked) write("0\r\n\r\n");
}

bool ResponseWriter::flush() {
  Uptake uptake(connection_, pace_limits_, pace_limits_);
  while (!broken_) {
    broken_ = !send_pending(connection_);
    if (broken_ || connection_.pending_output() == 0) break;
    broken_ = !wait_for_client(uptake);
  }
  return !broken_;
}

bool ResponseWriter::finish() {
  bool full = false;
  broken_ = broken_ || !send_pending(connection_, kMostOutput, full) ||
            (connection_.pending_output() > 0 && !leave_behind({}));
  return !broken_;
}

}  // namespace sightline
