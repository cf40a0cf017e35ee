#pragma once
/// The log of a server: lines for people, or one JSON object each for machines.

#include <spdlog/logger.h>

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <variant>

namespace sightline {

enum class LogFormat { kText, kJson };

/// Values may be anything that a client has said: no line ends in them, and no quote.
struct LogField {
  std::string_view name;
  std::variant<std::string_view, std::int64_t, std::uint64_t, double> value;
};

/// May be used from many threads.
class Log {
 public:
  using Level = spdlog::level::level_enum;
  using Fields = std::initializer_list<LogField>;

  /// "trace" to "off"; to `sink`.
  Log(LogFormat format, const std::string& level, spdlog::sink_ptr sink);
  void set_level(const std::string& level) { logger_.set_level(spdlog::level::from_str(level)); }

  bool shows(Level level) const { return logger_.should_log(level); }
  /// Text: "[time] [level] message name=value". JSON: {"time","level","message","name":value}. A
  /// field with an empty text is left out.
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
