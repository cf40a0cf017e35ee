#pragma once
/// Log: the log of a server, as lines for people or as JSON objects for programs.

#include <spdlog/logger.h>

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <variant>

namespace sightline {

enum class LogFormat { kText, kJson };

/// A named value of a log entry. It may be any text of a client: line ends and quotes in it are
/// escaped.
struct LogField {
  std::string_view name;
  std::variant<std::string_view, std::int64_t, std::uint64_t, double> value;
};

/// Thread-safe.
class Log {
 public:
  using Level = spdlog::level::level_enum;
  using Fields = std::initializer_list<LogField>;

  /// `level` is "trace" to "off". Entries go to `sink`.
  Log(LogFormat format, const std::string& level, spdlog::sink_ptr sink);
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
