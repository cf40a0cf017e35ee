#pragma once
/// One connection's bytes, buffered both ways.

#include <httplib.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace sightline {

/// Reads and writes a non-owned socket. Writes are collected, so that the head and a small body of
/// an answer leave in one packet; they leave when the buffer is full, before a read that has to
/// wait, and at flush().
class ConnectionStream final : public httplib::Stream {
 public:
  struct Timeouts {
    std::chrono::milliseconds read{5000};
    std::chrono::milliseconds write{5000};
  };
  ConnectionStream(int socket, Timeouts timeouts);

  bool is_readable() const override;
  bool is_writable() const override;
  ssize_t read(char* data, std::size_t size) override;
  ssize_t write(const char* data, std::size_t size) override;
  using httplib::Stream::write;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  socket_t socket() const override;

  /// With the next byte a request begins. Of its head a Range is not shown to the reader: the
  /// library refuses a malformed one, and one of an unknown unit, before anybody can tell it that
  /// there are no ranges here. A server may leave any Range alone, and of other methods than GET it
  /// must [RFC9110] 14.2.
  void begin_head();

  bool flush();
  /// Whether bytes are here that no request has taken yet.
  bool has_buffered() const { return read_at_ < read_end_; }
  /// Bytes that requests have taken so far.
  std::uint64_t bytes_read() const { return bytes_read_; }

 private:
  bool fill();
  void hide_range(char* data, std::size_t size);

  int socket_;
  Timeouts timeouts_;
  std::vector<char> read_buffer_;
  std::size_t read_at_ = 0, read_end_ = 0;
  std::uint64_t bytes_read_ = 0;
  std::string write_buffer_;
  bool in_head_ = false;
  std::size_t line_size_ = 0;  ///< of the head's line so far, without its end
  bool may_be_range_ = false;
};

/// Waits until one of the two can be read (or is closed). `second` may be -1.
struct Readable {
  bool first = false, second = false;
};
Readable wait_readable(int first, int second, std::chrono::milliseconds timeout);

}  // namespace sightline
