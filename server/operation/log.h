#pragma once
/// Log: the log of a server, as lines for people or as JSON objects for programs.

#include <spdlog/logger.h>

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <variant>

namespace sightline {

/// The form of the entries of a log.
enum class LogFormat { kText, kJson };

/// A named value of a log entry. A text may be any text of a client: line ends and quotes are
/// escaped. It is read during the call of write().
struct LogField {
  std::string_view name;
  std::variant<std::string_view, std::int64_t, std::uint64_t, double> value;
};

/// Writes entries to a sink, each as one line. Thread-safe if the sink is.
class Log {
 public:
  using Level = spdlog::level::level_enum;
  using Fields = std::initializer_list<LogField>;

  /// `level` is "trace", "debug", "info", "warn", "error" or "off"; lower entries are left out.
  Log(LogFormat format, const std::string& level, spdlog::sink_ptr sink);
  /// Sets the level while other threads write.
  void set_level(const std::string& level) { logger_.set_level(spdlog::level::from_str(level)); }

  /// True if entries of this level are written.
  bool shows(Level level) const { return logger_.should_log(level); }
  /// Writes an entry. Text: "[time] [level] message name=value". JSON:
  /// {"time","level","message","name":value}. Fields with an empty text are left out.
  void write(Level level, std::string_view message, Fields fields = {});
  void debug(std::string_view message, Fields fields = {}) { write(Level::debug, message, fields); }
  void info(std::string_view message, Fields fields = {}) { write(Level::info, message, fields); }
  void warn(std::string_view message, Fields fields = {}) { write(Level::warn, message, fields); }
  void error(std::string_view message, Fields fields = {}) { write(Level::err, message, fields); }

 private:
  const LogFormat format_;
  spdlog::logger logger_;
};

}  // namespace sightline

// Tests: tests/integration/operator_test.py
