#pragma once
/// Who goes first where there are more threads than processors.

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace sightline {

/// Of the calling thread, for good: only a privileged process may raise it again.
inline void lower_priority() {
#if defined(__linux__)
  constexpr int kNice = 10;
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::syscall(SYS_gettid)), kNice);
#endif
}

}  // namespace sightline
