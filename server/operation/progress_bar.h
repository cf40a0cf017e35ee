#pragma once
/// One line on a terminal that says how far something long has come.

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/base/progress.h"

namespace sightline {

/// "importing [########........] 50%"; of a stage whose end is not known only its name.
std::string progress_line(const Progress::Reading& reading);

/// Writes to standard error, and only where that is a terminal; what is over within half a second
/// is not worth a line. The line is gone with this object.
class ProgressBar {
 public:
  /// `line` is asked ten times a second, on a thread of this object, until it says nothing more.
  using Line = std::function<std::optional<std::string>()>;
  explicit ProgressBar(Line line);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

 private:
  void run();

  const Line line_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_ = false;
  std::thread thread_;
};

}  // namespace sightline
