#pragma once
/// Writes the answer to one request: the header in one pass, then the body or a stream.

#include <chrono>
#include <string>
#include <string_view>

#include "server/http/answer_headers.h"
#include "server/http/connection.h"
#include "server/http/http_message.h"
#include "server/http/pace.h"
#include "server/http/request_memory.h"

namespace sightline {

/// Appends the status line and all headers of an answer, with the empty line. A stream has no
/// length: it is chunked, or to HTTP/1.0 ends with the connection.
/// is_last  false where the connection stays open for another request
void append_head(std::string& out, const RequestHead& head, const HttpResponse& response,
                 std::string_view request_id, bool is_last, const AnswerHeaders& headers);
/// The answer to a request that the event loop refuses: problem+json.
HttpResponse refusal(const RequestFault& fault, const std::string& request_id);

/// Collects writes, so that the header and a small body leave in one packet. What a client does not
/// take at once stays behind: up to 64 KiB in the connection's output, more in a temporary file.
/// Only a stream waits for its client.
class ResponseWriter {
 public:
  /// busy_rate  bytes per second that the client of a stream has to take while others wait for the
  ///            memory that the stream holds
  ResponseWriter(Connection& connection, const PaceLimits& pace, std::uint64_t busy_rate,
                 const RequestMemory& memory)
      : connection_(connection),
        pace_limits_(pace),
        busy_limits_{busy_rate, pace.window, pace.longest},
        memory_(memory) {}

  void write(std::string_view text);
  /// Writes the pieces of a stream until it ends or the client is gone.
  void write_stream(const HttpResponse& response, bool chunked);
  /// Sends all, waiting for the client as the pace allows. False when it is gone or too slow.
  bool flush();
  /// Sends what goes without waiting; the event loop sends the rest. False when the connection is
  /// broken.
  bool finish();

 private:
  bool send_with(std::string_view& more);
  /// How fast the client takes what waits for it.
  struct Uptake {
    Uptake(const Connection& connection, const PaceLimits& pace_limits,
           const PaceLimits& busy_limits)
        : taken(taken_by_client(connection)),
          pace(pace_limits, Pace::Clock::now()),
          busy_pace(busy_limits, Pace::Clock::now()) {}
    void look(const Connection& connection);

    std::uint64_t taken;  ///< bytes, at the last check
    Pace pace, busy_pace;
  };
  bool wait_for_client(Uptake& uptake);
  /// Stores what is not sent yet, and `rest`. False where neither the memory nor the spool has
  /// room.
  bool leave_behind(std::string_view rest);
  bool spool(std::string_view rest);

  Connection& connection_;
  const PaceLimits pace_limits_, busy_limits_;
  const RequestMemory& memory_;
  bool broken_ = false;
};

/// Interval of the check whether a slow client delays other requests.
inline constexpr std::chrono::milliseconds kSlowClientLook{100};

/// Waits until there is something to receive, or the connection has ended. False at `due`.
bool wait_until_readable(int socket, std::chrono::steady_clock::time_point due);

}  // namespace sightline
