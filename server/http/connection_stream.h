#pragma once
/// What the library reads and writes of one exchange: a head that is here already, and the answer.

#include <httplib.h>

#include <chrono>
#include <string>
#include <string_view>

#include "server/http/connection.h"
#include "server/http/pace.h"
#include "server/http/work_memory.h"

namespace sightline {

/// Reads a head that says nothing, and then nothing: the event loop has read the client's, and
/// bodies go by BodyReader. Writes are collected, so that the head and a small body of an answer
/// leave in one packet. What a client does not take at once stays behind: up to 64 KiB in the
/// connection's output, more in a temporary file. Only a stream waits for its client.
class ConnectionStream final : public httplib::Stream {
 public:
  /// busy_rate  bytes per second, see hurry_for
  ConnectionStream(Connection& connection, const PaceLimits& pace, std::uint64_t busy_rate)
      : connection_(connection),
        pace_limits_(pace),
        hurry_limits_{busy_rate, pace.window, pace.longest},
        unread_(connection.head.http10 ? "GET / HTTP/1.0\r\n\r\n" : "GET / HTTP/1.1\r\n\r\n") {}

  bool is_readable() const override { return !unread_.empty(); }
  bool is_writable() const override { return !broken_; }
  ssize_t read(char* data, std::size_t size) override;
  ssize_t write(const char* data, std::size_t size) override;
  using httplib::Stream::write;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  socket_t socket() const override;

  /// What is written next is the head of an answer: `lines` go behind its first line.
  void add_to_head(std::string lines) { head_lines_ = std::move(lines); }
  /// What a stream writes next is in `memory`, which outlives the writing: while others wait for it
  /// the client has to take the answer at the busy rate.
  void hurry_for(const RequestMemory& memory) { memory_ = &memory; }
  /// Sends all, waiting for the client as the pace allows. False when it is gone or too slow.
  bool flush();
  /// Sends what goes without waiting; the event loop sends the rest. False when the connection is
  /// broken.
  bool finish();
  bool is_broken() const { return broken_; }
  /// From now on nothing is written: somebody else will answer.
  void fall_silent() { silent_ = true; }

 private:
  void collect_head(std::string_view head);
  bool send_with(std::string_view& more);
  /// How fast the client takes what waits for it.
  struct Uptake {
    Uptake(const Connection& connection, const PaceLimits& pace_limits,
           const PaceLimits& hurry_limits)
        : taken(taken_by_client(connection)),
          pace(pace_limits, Pace::Clock::now()),
          hurry(hurry_limits, Pace::Clock::now()) {}
    void look(const Connection& connection);

    std::uint64_t taken;  ///< bytes, at the last check
    Pace pace, hurry;
  };
  bool wait_for_client(Uptake& uptake);
  /// Stores what is not sent yet, and `rest`. False where neither the memory nor the spool has
  /// room.
  bool leave_behind(std::string_view rest);
  bool spool(std::string_view rest);

  Connection& connection_;
  const PaceLimits pace_limits_, hurry_limits_;
  std::string_view unread_;
  const RequestMemory* memory_ = nullptr;
  bool broken_ = false, silent_ = false;
  std::string head_lines_;
};

/// Interval of the check whether a slow client delays other requests.
inline constexpr std::chrono::milliseconds kSlowClientLook{100};

/// Waits until there is something to receive, or the connection has ended. False at `due`.
bool wait_until_readable(int socket, std::chrono::steady_clock::time_point due);

}  // namespace sightline
