#include "server/operation/signals.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <limits>

namespace sightline {

Signals::Signals() {
  sigset_t wanted;
  sigemptyset(&wanted);
  sigaddset(&wanted, SIGTERM);
  sigaddset(&wanted, SIGINT);
  sigaddset(&wanted, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &wanted, &before_);
  signals_ = ::signalfd(-1, &wanted, SFD_CLOEXEC | SFD_NONBLOCK);
  woken_ = ::eventfd(0, EFD_CLOEXEC);
}

Signals::~Signals() {
  // A signal that came after the last wait is answered by what is happening: the end.
  signalfd_siginfo info{};
  while (::read(signals_, &info, sizeof info) > 0) {
  }
  ::close(signals_);
  ::close(woken_);
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

Signals::Event Signals::wait(std::optional<std::chrono::milliseconds> timeout) {
  const auto begin = std::chrono::steady_clock::now();
  for (;;) {
    int left_ms = -1;
    if (timeout) {
      const auto left = *timeout - std::chrono::duration_cast<std::chrono::milliseconds>(
                                       std::chrono::steady_clock::now() - begin);
      left_ms =
          static_cast<int>(std::clamp<long long>(left.count(), 0, std::numeric_limits<int>::max()));
    }
    pollfd wanted[2] = {{signals_, POLLIN, 0}, {woken_, POLLIN, 0}};
    const int ready = ::poll(wanted, 2, left_ms);
    if (ready == 0) return Event::kTimeout;
    if (ready < 0) continue;  // interrupted
    if (wanted[1].revents != 0) {
      std::uint64_t times = 0;
      (void)!::read(woken_, &times, sizeof times);
      return Event::kWoken;
    }
    signalfd_siginfo info{};
    if (::read(signals_, &info, sizeof info) == static_cast<ssize_t>(sizeof info)) {
      const bool reload = info.ssi_signo == SIGHUP && info.ssi_code != SI_KERNEL;
      if (!reload) last_stop_ = static_cast<int>(info.ssi_signo);
      return reload ? Event::kReload : Event::kStop;
    }
  }
}

int Signals::let_through() {
  sigset_t last;
  sigemptyset(&last);
  sigaddset(&last, last_stop_);
  pthread_sigmask(SIG_UNBLOCK, &last, nullptr);
  ::kill(::getpid(), last_stop_);
  return 128 + last_stop_;
}

void Signals::wake() {
  const std::uint64_t one = 1;
  (void)!::write(woken_, &one, sizeof one);
}

}  // namespace sightline
