#pragma once
/// ResponseWriter: writes the answer to a request: the header in one write, then the body or a
/// stream.

#include <chrono>
#include <string>
#include <string_view>

#include "server/http/answer_headers.h"
#include "server/http/connection.h"
#include "server/http/http_message.h"
#include "server/http/pace.h"
#include "server/http/request_memory.h"

namespace sightline {

/// Appends the status line, all headers and the empty line of an answer. A stream has no length: it
/// is chunked, or for HTTP/1.0 ends with the connection.
/// is_last  true if the connection ends after this answer
void append_head(std::string& out, const RequestHead& head, const HttpResponse& response,
                 std::string_view request_id, bool is_last, const AnswerHeaders& headers);
/// The answer to a request that the event loop refuses, as problem+json.
HttpResponse refusal(const RequestFault& fault, const std::string& request_id);

/// Writes the answer to one request: write() or write_stream(), then finish(). It collects writes,
/// so that the header and a small body leave in one packet. What the client does not take at once
/// stays in the connection's output, up to 64 KiB, and beyond that in a temporary file. Only a
/// stream waits for its client. Not thread-safe.
class ResponseWriter {
 public:
  /// `connection` and `memory` must outlive the writer; `pace` is copied.
  /// busy_rate  least bytes per second of the client of a stream while other requests wait for the
  ///            memory that the stream holds
  ResponseWriter(Connection& connection, const PaceLimits& pace, std::uint64_t busy_rate,
                 const RequestMemory& memory)
      : connection_(connection),
        pace_limits_(pace),
        busy_limits_{busy_rate, pace.window, pace.longest},
        memory_(memory) {}

  /// Appends a text to the answer. After a failure, which finish() returns, further texts are
  /// dropped.
  void write(std::string_view text);
  /// Writes the pieces of a stream until it ends or the client is gone. Precondition:
  /// response.stream is not null.
  /// chunked  false for a client of HTTP/1.0: the end of the connection ends the body
  void write_stream(const HttpResponse& response, bool chunked);
  /// Sends everything, waiting for the client as the pace allows; for the thread of a stream only.
  /// Returns false if the client is gone or too slow.
  bool flush();
  /// Sends what can be sent without waiting; the event loop sends the rest. Returns false if the
  /// connection is broken, or neither memory nor spool has room for the rest. The connection must
  /// then be closed, because the answer is incomplete.
  bool finish();

 private:
  bool send_with(std::string_view& more);
  /// How fast the client takes the output.
  struct Uptake {
    Uptake(const Connection& connection, const PaceLimits& pace_limits,
           const PaceLimits& busy_limits)
        : taken(taken_by_client(connection)),
          pace(pace_limits, Pace::Clock::now()),
          busy_pace(busy_limits, Pace::Clock::now()) {}
    void look(const Connection& connection);

    std::uint64_t taken;  ///< acknowledged bytes at the last check
    Pace pace, busy_pace;
  };
  bool wait_for_client(Uptake& uptake);
  /// Stores the unsent output, and `rest`. Returns false if neither memory nor spool has room.
  bool leave_behind(std::string_view rest);
  bool spool(std::string_view rest);

  Connection& connection_;
  const PaceLimits pace_limits_, busy_limits_;
  const RequestMemory& memory_;
  bool broken_ = false;
};

/// How often a stream checks if its slow client delays other requests.
inline constexpr std::chrono::milliseconds kSlowClientLook{100};

/// Waits until bytes arrive or the connection ends. Returns false at `due`.
bool wait_until_readable(int socket, std::chrono::steady_clock::time_point due);

}  // namespace sightline

// Tests: tests/integration/abuse_test.py
