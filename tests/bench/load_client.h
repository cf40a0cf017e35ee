#pragma once
/// Many keep-alive connections, each with one request under way, from one thread.

#include <cstdint>
#include <string>

namespace sightline::bench {

struct LoadResult {
  std::uint64_t answers = 0;
  double seconds = 0;
  std::uint64_t failed = 0;  ///< connections that ended, or gave anything but 200
};

/// Sends `request` again and again on each of so many connections to 127.0.0.1, for so long and
/// until every request that was begun is answered. Answers have a length or come in chunks.
LoadResult put_load(int port, int connections, const std::string& request, double seconds);

/// Whether somebody listens.
bool is_listening(int port);
/// A port that nobody has now.
int free_port();

}  // namespace sightline::bench
