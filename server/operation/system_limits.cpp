#include "server/operation/system_limits.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace sightline {

std::size_t allowed_connections(const HttpLimits& limits) {
  // Each worker may read or write a file; and there are the standard ones, sockets and folders.
  const std::size_t others = 2 * std::min<std::size_t>(limits.workers, 64) + 64;
  const rlim_t wanted = limits.connections + others;
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) != 0) return limits.connections;
  if (files.rlim_cur < wanted && files.rlim_cur < files.rlim_max) {
    files.rlim_cur = std::min(wanted, files.rlim_max);
    (void)::setrlimit(RLIMIT_NOFILE, &files);
    (void)::getrlimit(RLIMIT_NOFILE, &files);
  }
  const std::size_t fit = files.rlim_cur > others ? files.rlim_cur - others : 0;
  return std::min(limits.connections.get(), std::max<std::size_t>(fit, 16));
}

std::uint64_t machine_memory() {
  std::uint64_t bytes = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                        static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  for (const char* limit :
       {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    // "max" is no number.
    std::uint64_t most = 0;
    if (std::ifstream(limit) >> most) bytes = std::min(bytes, most);
  }
  return bytes;
}

}  // namespace sightline
