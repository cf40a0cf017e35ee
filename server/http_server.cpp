#include "server/http_server.h"

#include <fcntl.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <new>
#include <utility>

#include "server/http_status.h"
#include "server/request_framing.h"

namespace sightline {
namespace {

/// A body that a route did not read is read over when it is no longer than this, so that the
/// connection lives on; else the connection ends.
constexpr std::uint64_t kSkippedBody = 64 << 10;
/// How much of what a client still sends is taken in before a close, and for how long: closing over
/// unread bytes would reset the connection, and the client would lose the answer.
constexpr std::size_t kLingerBytes = 1 << 20;
constexpr std::chrono::milliseconds kLinger{1000};
constexpr int kBacklog = 1024;

/// Where the body of a request ends on its connection.
struct BodyEnd {
  bool known = false;  ///< not that of a chunked body: only reading it tells
  std::uint64_t at = 0;
};

BodyEnd body_end_of(const httplib::Request& request, std::uint64_t begin) {
  if (find_framing_fault(request) || request.has_header("Transfer-Encoding")) return {};
  // No fault: digits, if anything.
  const std::string text = request.get_header_value("Content-Length");
  std::uint64_t length = 0;
  std::from_chars(text.data(), text.data() + text.size(), length);
  return {true, begin + length};
}

/// Whether all that is wrong with the request line is its method. The headers were not read then.
bool is_unknown_method(const httplib::Request& request) {
  constexpr std::array<std::string_view, 10> kKnown{
      "GET", "HEAD", "POST", "PUT", "DELETE", "CONNECT", "OPTIONS", "TRACE", "PATCH", "PRI"};
  const std::string& method = request.method;
  return !method.empty() && method.size() <= 32 && request.version.starts_with("HTTP/1.") &&
         std::all_of(method.begin(), method.end(), [](char c) { return c >= 'A' && c <= 'Z'; }) &&
         std::find(kKnown.begin(), kKnown.end(), method) == kKnown.end();
}

/// Whether what is unread of a body is worth reading, to keep the connection.
bool is_skippable(const ConnectionStream& stream, const BodyEnd& end) {
  return end.known && stream.bytes_read() <= end.at && end.at - stream.bytes_read() <= kSkippedBody;
}

/// Takes the rest of a body out of the way. False when the connection has to end.
bool skip_body(ConnectionStream& stream, const BodyEnd& end) {
  if (!is_skippable(stream, end)) return false;
  std::array<char, 4096> buffer{};
  while (stream.bytes_read() < end.at) {
    const auto wanted = std::min<std::uint64_t>(buffer.size(), end.at - stream.bytes_read());
    if (stream.read(buffer.data(), static_cast<std::size_t>(wanted)) <= 0) return false;
  }
  return true;
}

void linger(int socket) {
  ::shutdown(socket, SHUT_WR);
  std::array<char, 16384> buffer{};
  std::size_t taken = 0;
  const auto end = std::chrono::steady_clock::now() + kLinger;
  while (taken < kLingerBytes) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    if (left.count() <= 0 || !wait_readable(socket, -1, left).first) return;
    const ssize_t got = ::recv(socket, buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (got <= 0) return;
    taken += static_cast<std::size_t>(got);
  }
}

}  // namespace

Result<ListenAddress> parse_listen_address(const std::string& text) {
  const Error invalid{ErrorKind::kInvalid, "LISTEN_ADDRESS_INVALID",
                      "'" + text + "' is no address: write ADDR:PORT or [ADDR]:PORT", ""};
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return invalid;
  ListenAddress address{text.substr(0, colon), 0};
  const char* begin = text.data() + colon + 1;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(begin, end, address.port);
  if (begin == end || error != std::errc() || last != end || address.port < 0 ||
      address.port > 65535) {
    return invalid;
  }
  if (address.host.starts_with('[')) {
    if (address.host.size() < 3 || address.host.back() != ']') return invalid;
    address.host = address.host.substr(1, address.host.size() - 2);
  } else if (address.host.find(':') != std::string::npos) {
    return invalid;
  }
  if (address.host.empty()) return invalid;
  return address;
}

HttpServer::HttpServer(const HttpOptions& options, Dispatch dispatch, Thrown thrown)
    : options_(options),
      dispatch_(std::move(dispatch)),
      thrown_(std::move(thrown)),
      stop_event_(::eventfd(0, EFD_CLOEXEC)) {
  set_tcp_nodelay(true);  // without it an answer waits 40 ms for the client's acknowledgement
  // Only what the Keep-Alive header says: the connection loop is ours.
  set_keep_alive_timeout(std::chrono::duration_cast<std::chrono::seconds>(options.idle).count());
  set_keep_alive_max_count(1'000'000);
  // Without this the library sets SO_REUSEPORT, and two servers share a port in silence.
  set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  new_task_queue = [this] { return new httplib::ThreadPool(options_.workers); };

  // Methods without a body end before the library's router; the others match this one pattern,
  // because only a pattern gives a route the means to read the body itself.
  set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    if (const auto fault = find_framing_fault(request)) {
      Exchange exchange{request, response, nullptr, request_id_of(request), {}};
      exchange.reply_problem(400, fault->code, fault->detail);
      return HandlerResponse::Handled;
    }
    for (const char* method : {"POST", "PUT", "PATCH", "DELETE"}) {
      if (request.method == method) return HandlerResponse::Unhandled;
    }
    this->dispatch(request, response, nullptr);
    return HandlerResponse::Handled;
  });
  const HandlerWithContentReader with_body =
      [this](const httplib::Request& request, httplib::Response& response,
             const httplib::ContentReader& body) { this->dispatch(request, response, &body); };
  constexpr const char* kAnything = R"([\s\S]*)";
  Post(kAnything, with_body);
  Put(kAnything, with_body);
  Patch(kAnything, with_body);
  Delete(kAnything, with_body);

  // What the library adds to every answer, where it is not true.
  set_post_routing_handler([](const httplib::Request& request, httplib::Response& response) {
    response.headers.erase("Accept-Ranges");
    if (request.response_handler && !request.response_handler(response)) {
      response.headers.erase("Connection");
      response.set_header("Connection", "close");
    }
    if (response.status == 204) response.headers.erase("Content-Length");
    if (response.has_header("Connection")) response.headers.erase("Keep-Alive");
  });

  // Requests that the library refused by itself have no body yet.
  const HandlerWithResponse without_body = [this](const httplib::Request& request,
                                                  httplib::Response& response) {
    if (!response.body.empty()) return HandlerResponse::Unhandled;
    answer_unparsed(request, response);
    return HandlerResponse::Handled;
  };
  set_error_handler(without_body);
  // The default one would tell the client what the exception said.
  set_exception_handler([this](const httplib::Request& request, httplib::Response& response,
                               std::exception_ptr exception) {
    Exchange exchange{request, response, nullptr, request_id_of(request), {}};
    std::string what = "unknown exception";
    bool out_of_memory = false;
    try {
      std::rethrow_exception(std::move(exception));
    } catch (const std::bad_alloc& caught) {
      out_of_memory = true;
      what = caught.what();
    } catch (const std::exception& caught) {
      what = caught.what();
    } catch (...) {
      what = "not a std::exception";
    }
    thrown_(exchange.request_id, what);
    if (out_of_memory) {
      exchange.reply_problem(507, "MEMORY_FULL", "there is no memory left for this request");
    } else {
      exchange.reply_problem(500, "INTERNAL", "the server failed to answer; the fault is its own");
    }
  });
}

HttpServer::~HttpServer() {
  if (listener_ >= 0) ::close(listener_);
  if (stop_event_ >= 0) ::close(stop_event_);
}

Result<int> HttpServer::bind(const ListenAddress& address) {
  int port = address.port;
  if (port == 0) {
    port = bind_to_any_port(address.host);
  } else if (!bind_to_port(address.host, port)) {
    port = -1;
  }
  if (port < 0) {
    return Error{ErrorKind::kConflict, "LISTEN_FAILED",
                 "cannot listen on " + address.host + ":" + std::to_string(address.port) +
                     ": the port is taken, or the address is not this machine's",
                 ""};
  }
  // The library asks for a queue of 5.
  ::listen(svr_sock_, kBacklog);
  listener_ = ::fcntl(svr_sock_, F_DUPFD_CLOEXEC, 0);
  return port;
}

void HttpServer::serve() { listen_after_bind(); }

void HttpServer::stop() {
  stopping_ = true;
  const std::uint64_t one = 1;
  (void)!::write(stop_event_, &one, sizeof one);
  // Wakes the accept of serve(), or makes its first one fail if it has not got there yet.
  // httplib's own stop() does nothing before that point.
  if (listener_ >= 0) ::shutdown(listener_, SHUT_RDWR);
}

void HttpServer::break_connections() {
  const std::lock_guard hold(mutex_);
  for (const int socket : sockets_) ::shutdown(socket, SHUT_RDWR);
}

bool HttpServer::wait_for_request(int socket, const ConnectionStream& stream) const {
  if (stream.has_buffered()) return true;
  const Readable ready = wait_readable(socket, stop_event_, options_.idle);
  // After a stop what has already been sent is still answered; silence ends the connection.
  return ready.first || (ready.second && wait_readable(socket, -1, {}).first);
}

void HttpServer::answer_requests(int socket, ConnectionStream& stream) {
  while (wait_for_request(socket, stream)) {
    BodyEnd end;
    bool wants_close = false;
    stream.begin_head();
    const bool answered =
        process_request(stream, stopping_, wants_close, [&](httplib::Request& request) {
          end = body_end_of(request, stream.bytes_read());
          // The library asks this only of its client; here the request takes the question to the
          // place where the head of the answer is made: does the connection stay?
          request.response_handler = [&](const httplib::Response&) {
            return !wants_close && !stopping_ && is_skippable(stream, end);
          };
          // This too is a question of its client; here it lets a stream of events out of the
          // buffer.
          request.progress = [&](std::uint64_t, std::uint64_t) { return stream.flush(); };
          // Where HTTP/1.0 asks to keep the connection it would not know where a stream ends.
          if (request.version == "HTTP/1.0") wants_close = true;
          // No compression that costs more than the trace.
          request.headers.erase("Accept-Encoding");
        });
    const bool body_gone = answered && stream.flush() && skip_body(stream, end);
    if (!body_gone) return linger(socket);
    if (wants_close || stopping_) return;
  }
}

bool HttpServer::process_and_close_socket(socket_t socket) {
  {
    const std::lock_guard hold(mutex_);
    sockets_.insert(socket);
  }
  ConnectionStream stream(socket, options_.timeouts);
  answer_requests(socket, stream);
  stream.flush();
  {
    const std::lock_guard hold(mutex_);
    sockets_.erase(socket);
  }
  ::shutdown(socket, SHUT_RDWR);
  ::close(socket);
  return true;
}

void HttpServer::dispatch(const httplib::Request& request, httplib::Response& response,
                          const httplib::ContentReader* body) const {
  Exchange exchange{request, response, body, request_id_of(request), {}};
  dispatch_(exchange);
}

void HttpServer::answer_unparsed(const httplib::Request& request,
                                 httplib::Response& response) const {
  Exchange exchange{request, response, nullptr, request_id_of(request), {}};
  // Where the next request would begin is not known.
  response.set_header("Connection", "close");
  // A method that the library has not heard of is as wrong as one that a path does not have.
  if (response.status == 400 && is_unknown_method(request)) return dispatch_(exchange);
  switch (response.status) {
    case 414:
      return exchange.reply_problem(414, "URI_TOO_LONG", "the request's path is too long");
    default:
      return exchange.reply_problem(response.status >= 500 ? 500 : 400, "REQUEST_MALFORMED",
                                    "this is not an HTTP/1.1 request that the server understands");
  }
}

}  // namespace sightline
