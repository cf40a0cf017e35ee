#include "server/http/http_server.h"

#include <cxxabi.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <typeinfo>
#include <utility>

#include "server/http/body_reader.h"
#include "server/http/response_writer.h"

namespace sightline {
namespace {

/// How long a request that finds no memory begins again.
constexpr std::chrono::minutes kRepeats{10};

/// Encodes the body in the coding that the client prefers, where that pays: raw numbers hardly
/// shrink, unless the route says Vary, and a short answer fits a packet already.
void compress(const RequestHead& head, HttpResponse& response) {
  constexpr std::size_t kWorthIt = 1400;
  if (response.body.size() < kWorthIt) return;
  const bool varies = response.header("Vary") != nullptr;
  if (response.content_type == "application/octet-stream" && !varies) return;
  if (!varies) response.set_header("Vary", "Accept-Encoding");
  if (head.accepts == Coding::kIdentity) return;
  response.body = ContentEncoder(head.accepts).encode(response.body, true);
  response.set_header("Content-Encoding", std::string(coding_name(head.accepts)));
}

std::string type_name(const std::exception& exception) {
  const char* raw = typeid(exception).name();
  const std::unique_ptr<char, void (*)(void*)> name(
      abi::__cxa_demangle(raw, nullptr, nullptr, nullptr), std::free);
  return name ? name.get() : raw;
}

}  // namespace

HttpServer::HttpServer(const HttpLimits& limits, Dispatch dispatch, Thrown thrown,
                       EventLoopCallbacks rules)
    : limits_(limits),
      dispatch_(std::move(dispatch)),
      thrown_(std::move(thrown)),
      memory_(limits.memory, limits.request),
      spool_(limits.spool_folder, limits.spool_bytes),
      loop_(
          limits_, memory_, spool_, [this](Connection& connection) { answer(connection); },
          std::move(rules)) {}

HttpServer::~HttpServer() {
  if (listener_ >= 0) ::close(listener_);
}

Result<int> HttpServer::bind(const ListenAddress& address) {
  auto socket = listen_on(address);
  if (!socket) return std::move(socket).error();
  listener_ = socket->descriptor;
  if (Status started = loop_.start(); !started) return std::move(started).error();
  return socket->port;
}

void HttpServer::serve() { loop_.run(listener_); }

void HttpServer::stop() {
  stopping_ = true;
  loop_.stop();
}

void HttpServer::break_connections() {
  stopping_ = true;
  loop_.break_off();
}

void HttpServer::handle(Exchange& exchange) const {
  std::string kind = "not a std::exception";
  bool out_of_memory = false;
  try {
    dispatch_(exchange);
    if (!exchange.is_put_off()) compress(exchange.head, exchange.response);
    return;
  } catch (const std::exception& caught) {
    kind = type_name(caught);
    out_of_memory = dynamic_cast<const std::bad_alloc*>(&caught) != nullptr;
  } catch (...) {
  }
  exchange.response = {};
  if (exchange.on_event_loop) return;  // a worker begins again, and reports it
  thrown_(exchange.request_id, kind);
  if (out_of_memory) {
    exchange.reply_problem(507, "MEMORY_FULL", "there is no memory left for this request");
  } else {
    exchange.reply_problem(500, "INTERNAL", "the server failed to answer; the fault is its own");
  }
}

void HttpServer::answer(Connection& connection) {
  const RequestHead& head = connection.head;
  using Wait = RequestMemory::Wait;
  RequestMemory memory(memory_, connection.plan,
                       connection.on_event_loop ? Wait::kNever
                       : connection.goes_first  ? Wait::kBegunAgain
                       : connection.streams     ? Wait::kStream
                                                : Wait::kWhileEmpty,
                       &connection.gone);
  ResponseWriter writer(connection, limits_.pace, limits_.busy_rate, memory);
  BodyReader body(connection, writer, limits_.pace, limits_.busy_rate, memory);
  HttpResponse response;
  Exchange exchange{
      .head = head,
      .response = response,
      .body = &body,
      .caller = &connection.gone,
      .memory = &memory,
      .request_id = checked_request_id(head.request_id, loop_.rules().is_secret),
      .on_event_loop = connection.on_event_loop,
      .asked_at = connection.asked_at,
      .may_repeat = !connection.streams && !connection.kept && !connection.gone.cancelled() &&
                    std::chrono::steady_clock::now() - connection.asked_at < kRepeats};
  if (loop_.rules().headers.is_preflight(head)) {
    exchange.reply_empty(204);
  } else {
    handle(exchange);
  }
  if (exchange.is_put_off()) {
    if (!body.is_put_off()) connection.put_off = Connection::PutOff::kToWorker;
    return;
  }
  if (!exchange.streams) memory.finish(response.body.size());
  const bool keeps = !head.close && !stopping_ && body.is_skippable();
  append_head(connection.output, head, response, exchange.request_id, !keeps,
              loop_.rules().headers);
  if (head.method != "HEAD") {
    response.stream ? writer.write_stream(response, !head.http10) : writer.write(response.body);
  }
  // Of a stream that broke off half of the answer may be on its way: only the end says so.
  connection.broken = !writer.finish();
  connection.keep = !connection.broken && keeps && body.is_skippable();
  connection.skip = connection.keep ? body.unread() : 0;
  body.finish();
}

}  // namespace sightline
