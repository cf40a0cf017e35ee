#include "server/operation/progress_bar.h"

#include <unistd.h>

#include <chrono>
#include <string_view>

namespace sightline {
namespace {

constexpr int kWidth = 32;
constexpr std::chrono::milliseconds kPatience{500}, kBetween{100};

void write_text(std::string_view text) {
  // What a terminal does not take is not worth an error.
  (void)!::write(STDERR_FILENO, text.data(), text.size());
}

}  // namespace

std::string progress_line(const Progress::Reading& reading) {
  std::string line = reading.stage;
  if (!reading.percent) return line.empty() ? line : line + " ...";
  const int filled = *reading.percent * kWidth / 100;
  line += " [";
  for (int i = 0; i < kWidth; ++i) line += i < filled ? '#' : '.';
  return line + "] " + std::to_string(*reading.percent) + "%";
}

ProgressBar::ProgressBar(Line line) : line_(std::move(line)) {
  if (::isatty(STDERR_FILENO) == 1) thread_ = std::thread([this] { run(); });
}

ProgressBar::~ProgressBar() {
  {
    const std::lock_guard hold(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void ProgressBar::run() {
  std::unique_lock hold(mutex_);
  if (changed_.wait_for(hold, kPatience, [&] { return ended_; })) return;
  constexpr std::string_view kClear = "\r\x1b[K";
  std::string shown;
  while (!changed_.wait_for(hold, kBetween, [&] { return ended_; })) {
    std::optional<std::string> line = line_();
    if (!line) break;
    if (*line == shown) continue;
    shown = std::move(*line);
    write_text(std::string(kClear) + shown);
  }
  if (!shown.empty()) write_text(kClear);
}

}  // namespace sightline
