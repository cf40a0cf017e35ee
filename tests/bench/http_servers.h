#pragma once
/// The HTTP servers that the benchmarks compare, each a process of its own.

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

namespace sightline::bench {

/// What each answers to GET /healthz.
inline constexpr const char* kHealthBody = "{\"status\":\"ok\"}\n";

/// A server on a port of 127.0.0.1, ended with the object.
class ServerProcess {
 public:
  /// `sightline serve` with so many workers and these flags.
  static ServerProcess sightline(const std::string& binary, int workers,
                                 const std::vector<std::string>& flags = {});
  /// serve(port) in a process of its own; it does not return.
  static ServerProcess own(const std::function<void(int port)>& serve);
  /// cpp-httplib as it comes, tuned as its users do: TCP_NODELAY, connections that live on.
  static ServerProcess plain(int workers);
  /// nginx with `return 200` and one process. Its files go to `folder`.
  static ServerProcess nginx(const std::string& folder);

  ServerProcess(ServerProcess&& other) noexcept;
  ServerProcess& operator=(ServerProcess&&) = delete;
  ~ServerProcess();

  int port() const { return port_; }
  /// Processor time of the process so far, in microseconds.
  double cpu_us() const;

 private:
  ServerProcess(pid_t pid, int port);

  pid_t pid_ = -1;
  int port_ = 0;
};

}  // namespace sightline::bench
