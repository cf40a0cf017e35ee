#pragma once
/// A group of threads that share the work of parallel.h.

#include <functional>
#include <memory>

namespace sightline {

/// A limit of threads: calls of parallel.h inside execute() run on at most threads() threads at
/// once. Use: start(), then execute() from any number of threads. Builds with ThreadSanitizer set
/// no limit (parallel.h).
class ThreadGroup {
 public:
  ThreadGroup();
  ~ThreadGroup();

  /// Sets the number of threads; 0: one for each processor. Precondition: called once, before
  /// execute.
  void start(int threads);
  int threads() const;
  /// Lowers the priority of the threads that help the callers of execute, from now on.
  void give_way();
  /// Calls work() on the calling thread; other threads of the group help with its parallel calls.
  /// Throws what work() throws.
  template <class Work>
  void execute(const Work& work) {
    run(std::cref(work));
  }

 private:
  struct Arena;
  void run(const std::function<void()>& work);

  std::unique_ptr<Arena> arena_;
};

}  // namespace sightline

// Tests: tests/unit/base/parallel_test.cpp
