#pragma once
/// ProgressBar: a line on a terminal that shows the progress of a long operation.

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/base/progress.h"

namespace sightline {

/// The text of the line: "importing [########........] 50%"; "importing ..." if the total of the
/// stage is not known; empty before the first stage.
std::string progress_line(const Progress::Reading& reading);

/// Writes the line to standard error if that is a terminal, beginning half a second after
/// construction. The destructor waits for the thread and clears the line.
class ProgressBar {
 public:
  /// Called ten times a second on a thread of this object, until it returns no text.
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
