#pragma once
/// Thread priority: which thread runs first where there are more threads than processors.

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace sightline {

/// Lowers the priority of the calling thread for the rest of its life: nice level 5. Only a
/// privileged process could raise it again. Does nothing on systems other than Linux.
inline void lower_priority() {
#if defined(__linux__)
  constexpr int kNice = 5;
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::syscall(SYS_gettid)), kNice);
#endif
}

}  // namespace sightline

// Tests: tests/unit/base/parallel_test.cpp
