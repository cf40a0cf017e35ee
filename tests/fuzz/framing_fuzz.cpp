// Bytes of any kind on a connection, cut in any places: what is read does not depend on the cuts.
// Run:  scripts/stress.sh fuzz --target framing_fuzz
//
// The first byte of an input says how it is cut; the rest is what a client sends. It goes through
// the readers of heads and chunks as the event loop uses them, and every eighth through a whole server.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "server/http/body_reader.h"
#include "server/http/chunk_decoder.h"
#include "server/http/http_server.h"
#include "server/http/request_head.h"
#include "tests/fuzz/cuts.h"
#include "tests/fuzz/promise.h"

namespace {

using namespace sightline;

using fuzz::Cuts;
using fuzz::require;

/// Below every limit of time that the server has.
constexpr std::chrono::milliseconds kPatience{500};

/// One connection's requests as the event loop and the reader of bodies see them, written down.
class Reader {
 public:
  /// False once it is not known where the next request would begin.
  bool feed(std::string_view piece) {
    pending_.append(piece);
    for (;;) {
      const bool goes_on = in_body_ ? take_body() : take_head();
      if (!goes_on) return !ended_;
    }
  }
  const std::string& text() const { return text_; }

 private:
  bool end(const char* why) {
    ended_ = true;
    text_ += why;
    return false;
  }
  bool take_head() {
    if (ended_ || pending_.empty()) return false;
    switch (scan_.look(pending_, limits_)) {
      case HeadScan::State::kMore:
        return false;
      case HeadScan::State::kFault:
        return end(scan_.fault().code);
      case HeadScan::State::kWhole:
        break;
    }
    const std::string_view head =
        std::string_view(pending_).substr(scan_.begin(), scan_.size() - scan_.begin());
    if (const auto fault = parse_request_head(head, limits_, head_)) return end(fault->code);
    require(!(head_.chunked && head_.length), "a body has one end");
    require(head_.target.find_first_of(std::string_view("\r\n\0 ", 4)) == std::string::npos,
            "what is handed on is one word");
    text_ += head_.method + " " + head_.target + "|" + head_.host + "|" +
             head_.if_match.value_or("") + "|" + head_.if_none_match.value_or("") + "|";
    pending_.erase(0, scan_.size());
    scan_ = {};
    chunks_ = {};
    left_ = head_.length.value_or(0);
    in_body_ = true;
    return true;
  }
  bool take_body() {
    if (head_.chunked) {
      std::string_view coded = pending_;
      std::string payload(coded.size(), '\0');
      payload.resize(chunks_.decode(coded, payload.data()));
      text_ += payload;
      pending_.erase(0, pending_.size() - coded.size());
      if (chunks_.is_broken()) return end("chunks");
      if (!chunks_.is_over()) return false;
    } else {
      const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(left_, pending_.size()));
      text_.append(pending_, 0, count);
      pending_.erase(0, count);
      left_ -= count;
      if (left_ > 0) return false;
    }
    text_ += '\n';
    in_body_ = false;
    if (head_.close) return end("close");
    return true;
  }

  const HeadLimits limits_{.bytes = 1024, .fields = 16};
  std::string pending_, text_;
  HeadScan scan_;
  RequestHead head_;
  ChunkDecoder chunks_;
  std::uint64_t left_ = 0;
  bool in_body_ = false, ended_ = false;
};

std::string read_in_pieces(std::string_view stream, unsigned seed) {
  Reader reader;
  Cuts cuts(seed);
  while (!stream.empty()) {
    const std::size_t count = cuts.next(stream.size());
    if (!reader.feed(stream.substr(0, count))) break;
    stream.remove_prefix(count);
  }
  return reader.text();
}

/// The fuzzer's alarm clock would cut system calls short.
void let_system_calls_go_on() {
  struct sigaction action {};
  ::sigaction(SIGALRM, nullptr, &action);
  action.sa_flags |= SA_RESTART;
  ::sigaction(SIGALRM, &action, nullptr);
}

/// A server that says of each request what it was.
class Server {
 public:
  Server()
      : server_(HttpLimits{.workers = 8, .head = {.bytes = 1024, .fields = 16}}, echo,
                [](const std::string&, const std::string&) { require(false, "nothing throws"); }) {
    let_system_calls_go_on();
    const auto port = server_.bind({"127.0.0.1", 0});
    require(port.ok(), "there is a port");
    port_ = *port;
    thread_ = std::thread([this] { server_.serve(); });
  }
  ~Server() {
    server_.break_connections();
    thread_.join();
  }

  /// All that it answers to a client that sends this and closes its side; without ids and dates,
  /// and without asking for bodies, which need not be asked for once their first bytes are there.
  std::string answers(std::string_view stream, unsigned seed) const {
    const int client = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port_));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    require(::connect(client, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0,
            "the server is open");
    const int yes = 1;
    ::setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    Cuts cuts(seed);
    while (!stream.empty()) {
      const std::size_t count = cuts.next(stream.size());
      if (::send(client, stream.data(), count, MSG_NOSIGNAL) < 0) break;
      stream.remove_prefix(count);
    }
    ::shutdown(client, SHUT_WR);
    std::string text;
    char buffer[4096];
    for (ssize_t got = 0; (got = ::recv(client, buffer, sizeof buffer, 0)) > 0;) {
      text.append(buffer, static_cast<std::size_t>(got));
    }
    ::close(client);
    return without_asking(without_ids_and_dates(std::move(text)));
  }

 private:
  static void echo(Exchange& exchange) {
    std::string said = exchange.head.method + " " + exchange.head.target + "\n";
    if (exchange.body != nullptr) {
      if (!exchange.body->ask_for(1 << 20)) return;
      const bool whole = exchange.body->read([&](std::span<const char> piece) {
        said.append(piece.data(), piece.size());
        return true;
      });
      if (!whole || !exchange.body->is_over()) said += "broken";
    }
    exchange.reply(200, std::move(said), "text/plain");
  }
  /// What is another one in each answer.
  static std::string without_ids_and_dates(std::string text) {
    struct Changing {
      std::string_view name;
      std::size_t size;
    };
    for (const auto& [name, size] :
         {Changing{"X-Request-Id: ", 16}, {"\"request_id\":\"", 16}, {"Date: ", 29}}) {
      for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos;) {
        at += name.size();
        text.erase(at, std::min(size, text.size() - at));
      }
    }
    return text;
  }

  static std::string without_asking(std::string text) {
    constexpr std::string_view kAsking = "HTTP/1.1 100 Continue\r\n\r\n";
    for (std::size_t at = 0; (at = text.find(kAsking, at)) != std::string::npos;) {
      text.erase(at, kAsking.size());
    }
    return text;
  }

  HttpServer server_;
  int port_ = 0;
  std::thread thread_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Server server;
  if (size == 0) return 0;
  const std::string_view stream(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::string whole = read_in_pieces(stream, 0);
  require(read_in_pieces(stream, 1) == whole, "byte by byte reads alike");
  require(read_in_pieces(stream, data[0] + 2u) == whole, "pieces read alike");
  if (data[0] % 8 == 0 && size < 2048) {
    bool alike = false;
    // Where the machine stood still, the server's patience may have ended in one of the two.
    for (bool stood_still = true; !alike && stood_still;) {
      const auto began = std::chrono::steady_clock::now();
      alike = server.answers(stream, data[0] + 2u) == server.answers(stream, 0);
      stood_still = std::chrono::steady_clock::now() - began > kPatience;
    }
    require(alike, "answers are alike");
  }
  return 0;
}
