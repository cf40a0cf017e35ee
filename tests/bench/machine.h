#pragma once
/// The conditions of a measurement: one pinned thread, its own CPU time, huge pages for everybody.

#include <sched.h>

#include <functional>
#include <string>

namespace sightline::bench {

/// CPU time of the calling thread in nanoseconds: what another process took is not in it.
double thread_time_ns();

/// Wall time from some fixed moment on.
double wall_time_seconds();

/// Calls work() in a process of its own and returns what it returned; empty if that failed. For
/// what cannot be undone within a process: a peak of memory, a library's number of threads.
std::string in_own_process(const std::function<std::string()>& work);

/// Pins the calling thread while it lives. Builds run before, so that their threads are free.
class Pin {
 public:
  /// cpu < 0: the last one that this process may use.
  explicit Pin(int cpu);
  Pin(const Pin&) = delete;
  Pin& operator=(const Pin&) = delete;
  ~Pin();
  int cpu() const { return cpu_; }

 private:
  int cpu_;
  bool pinned_ = false;
  cpu_set_t before_;
};

/// Lets malloc ask for transparent huge pages, as the scene's own memory does. The setting is read
/// when a process starts, so this executes the program once more; call it first in main.
void start_again_with_huge_pages(char** argv);

/// KiB of this process that lie on transparent huge pages, and all that is resident.
struct PageUse {
  long huge_kib = 0;
  long resident_kib = 0;
};
PageUse page_use();

/// "Intel(R) Xeon(R) ..., 2 CPUs".
std::string machine_name();

}  // namespace sightline::bench
