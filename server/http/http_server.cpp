#include "server/http/http_server.h"

#include <cxxabi.h>
#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <new>
#include <system_error>
#include <typeinfo>
#include <utility>

#include "server/http/body_reader.h"
#include "server/http/connection_stream.h"

namespace sightline {
namespace {

constexpr int kBacklog = 1024;
/// How long a request that finds no memory begins again.
constexpr std::chrono::minutes kRepeats{10};

/// What stands around one call of process_request. The library has no place for it; a request
/// carries it as the target of a question that only the library's client would ask.
struct Course {
  Connection& connection;
  ConnectionStream& stream;
  BodyReader& body;
  RequestMemory& memory;
  const std::atomic<bool>& stopping;
  HttpRequest request{};
  HttpResponse response{};
  std::string request_id{};
  bool keeps = false;  ///< what the answer says of the connection

  void decide() { keeps = !connection.head.close && !stopping && body.is_skippable(); }
};

struct CourseOf {
  Course* course;
  bool operator()(const httplib::Response&) const { return course->keeps; }
};

/// It is there from before the library looks for who answers.
Course& course_of(const httplib::Request& request) {
  return *request.response_handler.target<CourseOf>()->course;
}

Exchange exchange_of(Course& course) {
  Connection& connection = course.connection;
  const RequestHead& head = connection.head;
  if (course.request_id.empty()) course.request_id = checked_request_id(head.request_id);
  return {.request = course.request,
          .response = course.response,
          .body = &course.body,
          .caller = &connection.gone,
          .memory = &course.memory,
          .request_id = course.request_id,
          .accepts = head.accepts,
          .at_door = connection.at_door,
          .asked_at = connection.asked_at,
          .whole_at = connection.asked_at,
          .may_repeat = !connection.streams && !connection.kept && !connection.gone.cancelled() &&
                        std::chrono::steady_clock::now() - connection.asked_at < kRepeats,
          .head = &head,
          .access = head.access,
          .key_name = head.key_name,
          .revoked = head.revoked};
}

/// The library's own look-up makes a text of the name and compares letter by letter.
bool has(const httplib::Headers& headers, std::string_view name) {
  return std::any_of(headers.begin(), headers.end(),
                     [&](const auto& header) { return header.first == name; });
}

/// In the coding that the client likes best, where that pays: raw numbers hardly shrink, and what
/// fits a packet need not.
void compress(const RequestHead& head, HttpResponse& response) {
  constexpr std::size_t kWorthIt = 1400;
  if (response.body.size() < kWorthIt) return;
  const std::string* type = response.header("Content-Type");
  if (type != nullptr && *type == "application/octet-stream") return;
  if (response.header("Vary") == nullptr) response.set_header("Vary", "Accept-Encoding");
  if (head.accepts == Coding::kIdentity) return;
  response.body = ContentEncoder(head.accepts).encode(response.body, true);
  response.set_header("Content-Encoding", std::string(coding_name(head.accepts)));
}

/// Hands the answer to the library, which writes it.
void hand_over(Course& course, httplib::Response& response) {
  HttpResponse& answer = course.response;
  response.status = answer.status;
  response.body = std::move(answer.body);
  std::string type;
  for (auto& [name, value] : answer.headers) {
    if (answer.stream && name == "Content-Type") {
      type = std::move(value);
    } else {
      response.headers.emplace(std::move(name), std::move(value));
    }
  }
  if (!answer.stream) return;
  const auto provide = [&course](std::size_t, httplib::DataSink& sink) {
    bool good = true;
    const bool goes_on = course.response.stream([&](std::string_view text) {
      // What was written leaves now, not when the buffer is full.
      good = sink.write(text.data(), text.size()) && course.stream.flush();
      return good;
    });
    if (!goes_on) sink.done();
    return good;
  };
  if (course.connection.head.http10) {
    // It knows no chunks: the end of the connection is the end of the stream.
    response.set_content_provider(type, provide);
  } else {
    response.set_chunked_content_provider(type, provide);
  }
}

/// What the library adds to every answer, where it is not true; and what it does not add.
void correct(const httplib::Request& request, httplib::Response& response,
             const AnswerHeaders& headers) {
  Course& course = course_of(request);
  const RequestHead& head = course.connection.head;
  if (head.method == "HEAD") response.headers.erase("Accept-Ranges");
  course.decide();
  // It was told that each connection ends: to say how long one is kept it would write a number by a
  // stream, of what may change while the server runs.
  if (course.keeps) response.headers.erase("Connection");
  // [RFC9110] 8.6
  if (response.status == 204 || response.status == 304) response.headers.erase("Content-Length");
  // In one piece, since each header that the library writes costs a call of printf.
  course.stream.add_to_head(
      "X-Request-Id: " + course.request_id + "\r\n" +
      headers.lines(head, {has(response.headers, "Cache-Control"),
                           has(response.headers, "Content-Security-Policy")}));
}

std::string type_name(const std::exception& exception) {
  const char* raw = typeid(exception).name();
  const std::unique_ptr<char, void (*)(void*)> name(
      abi::__cxa_demangle(raw, nullptr, nullptr, nullptr), std::free);
  return name ? name.get() : raw;
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

HttpServer::HttpServer(const DoorLimits& limits, Dispatch dispatch, Thrown thrown, DoorRules rules)
    : limits_(limits),
      dispatch_(std::move(dispatch)),
      thrown_(std::move(thrown)),
      traffic_(limits.traffic),
      spool_(limits.spool_folder, limits.spool_bytes),
      bodies_(traffic_, limits.bodies, std::numeric_limits<std::uint64_t>::max(), true),
      work_(traffic_, limits.work, limits.request),
      // Half of the workers may wait for loads: see serve_flags.cpp.
      waiters_(std::max<std::size_t>(1, limits.workers / 8)),
      gate_(
          limits_, traffic_, spool_, [this](Connection& connection) { answer(connection); },
          std::move(rules)) {
  // Without this the library sets SO_REUSEPORT, and two servers share a port in silence.
  set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  // Every request ends here, before the library's router, and before it would read a body.
  set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    Course& course = course_of(request);
    Exchange exchange = exchange_of(course);
    const RequestHead& head = course.connection.head;
    if (gate_.rules().headers.is_preflight(head)) {
      exchange.reply_empty(204);
    } else {
      dispatch_(exchange);
      if (exchange.is_put_off()) {
        if (!course.body.is_put_off()) course.connection.put_off = Connection::PutOff::kToWorker;
        course.stream.fall_silent();
      } else {
        compress(head, course.response);
        if (!exchange.streams) course.memory.keep(course.response.body.size());
        course.stream.hurry_for(course.memory);
      }
    }
    hand_over(course, response);
    return HandlerResponse::Handled;
  });
  set_post_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    correct(request, response, gate_.rules().headers);
  });
  // The default one would tell the client what the exception said.
  set_exception_handler([this](const httplib::Request& request, httplib::Response& response,
                               std::exception_ptr exception) {
    answer_thrown(request, response, std::move(exception));
  });
}

HttpServer::~HttpServer() {
  if (svr_sock_ != INVALID_SOCKET) ::close(svr_sock_);
}

Result<int> HttpServer::bind(const ListenAddress& address) {
  int port = address.port;
  errno = 0;
  if (port == 0) {
    port = bind_to_any_port(address.host);
  } else if (!bind_to_port(address.host, port)) {
    port = -1;
  }
  if (port < 0) {
    return Error{ErrorKind::kConflict, "LISTEN_FAILED",
                 "cannot listen on " + address.host + ":" + std::to_string(address.port) + ": " +
                     (errno != 0 ? std::generic_category().message(errno)
                                 : "the address is not this machine's"),
                 ""};
  }
  // The library asks for a queue of 5.
  ::listen(svr_sock_, kBacklog);
  ::fcntl(svr_sock_, F_SETFL, ::fcntl(svr_sock_, F_GETFL) | O_NONBLOCK);
  ::fcntl(svr_sock_, F_SETFD, FD_CLOEXEC);
  return port;
}

void HttpServer::serve() { gate_.run(svr_sock_); }

void HttpServer::stop() {
  stopping_ = true;
  gate_.stop();
}

void HttpServer::break_connections() {
  stopping_ = true;
  gate_.break_off();
}

void HttpServer::answer(Connection& connection) {
  ConnectionStream stream(connection, limits_.pace, limits_.busy_rate);
  RequestMemory memory(bodies_, work_, connection.goes_first ? &waiters_ : nullptr,
                       &connection.gone, connection.at_door);
  BodyReader body(connection, stream, limits_.pace, limits_.busy_rate, memory);
  Course course{connection, stream, body, memory, stopping_};
  bool wants_close = false;
  // cpp-httplib 0.11 (Debian 12) takes no addresses, 0.18 (Debian 13) does; nothing here reads them.
  const auto process = [&](auto& on, const auto& setup) {
    if constexpr (requires { this->process_request(on, true, wants_close, setup); }) {
      return this->process_request(on, true, wants_close, setup);
    } else {
      return this->process_request(on, {}, 0, {}, 0, true, wants_close, setup);
    }
  };
  const bool answered = process(stream, [&](httplib::Request& request) {
    // What was judged is what is answered.
    request.method = connection.head.method;
    request.target = connection.head.target;
    request.response_handler = CourseOf{&course};
    course.request = {connection.head.method, connection.head.target};
  });
  if (connection.put_off != Connection::PutOff::kNo) return;
  const bool sent = stream.finish() && answered;
  // Of a stream that broke off half of the answer may be on its way: only the end says so.
  connection.broken = stream.is_broken();
  connection.keep = sent && course.keeps && body.is_skippable();
  connection.skip = connection.keep ? body.unread() : 0;
  body.finish();
}

void HttpServer::answer_thrown(const httplib::Request& request, httplib::Response& response,
                               std::exception_ptr exception) const {
  Course& course = course_of(request);
  Exchange exchange = exchange_of(course);
  if (exchange.at_door) {
    course.connection.put_off = Connection::PutOff::kToWorker;
    return course.stream.fall_silent();
  }
  // What was put off before is answered here.
  course.connection.put_off = Connection::PutOff::kNo;
  std::string kind = "not a std::exception";
  bool out_of_memory = false;
  try {
    std::rethrow_exception(std::move(exception));
  } catch (const std::exception& caught) {
    kind = type_name(caught);
    out_of_memory = dynamic_cast<const std::bad_alloc*>(&caught) != nullptr;
  } catch (...) {
  }
  thrown_(exchange.request_id, kind);
  if (out_of_memory) {
    exchange.reply_problem(507, "MEMORY_FULL", "there is no memory left for this request");
  } else {
    exchange.reply_problem(500, "INTERNAL", "the server failed to answer; the fault is its own");
  }
  hand_over(course, response);
}

}  // namespace sightline
