#include "server/operation/log.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>

namespace sightline {
namespace {

std::string quoted(std::string_view text) {
  return nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

/// As it is where it is plain, so that people can read it.
std::string shown(std::string_view text) {
  const bool plain = std::all_of(
      text.begin(), text.end(), [](char c) { return c > ' ' && c < 0x7f && c != '"' && c != '='; });
  return plain ? std::string(text) : quoted(text);
}

std::string to_thousandths(double value) {
  std::array<char, 320> text;  // the largest float64 has 309 digits before its point
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, 3);
  return {text.data(), end.ptr};
}

std::string value_of(const LogField& field, LogFormat format) {
  return std::visit(
      [&](const auto& value) -> std::string {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, std::string_view>) {
          return format == LogFormat::kJson ? quoted(value) : shown(value);
        } else if constexpr (std::is_same_v<Value, double>) {
          return to_thousandths(value);
        } else {
          return std::to_string(value);
        }
      },
      field.value);
}

bool is_empty(const LogField& field) {
  const auto* text = std::get_if<std::string_view>(&field.value);
  return text != nullptr && text->empty();
}

/// A message is our own, but may hold what a library or a file said.
std::string one_line(std::string_view text) {
  std::string line(text);
  std::replace_if(
      line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
  return line;
}

}  // namespace

Log::Log(LogFormat format, const std::string& level, spdlog::sink_ptr sink)
    : format_(format), logger_("sightline", std::move(sink)) {
  set_level(level);
  if (format == LogFormat::kJson) {
    logger_.set_pattern(R"({"time":"%Y-%m-%dT%H:%M:%S.%e%z","level":"%l",%v})");
  } else {
    logger_.set_pattern("[%Y-%m-%d %H:%M:%S.%e] [%l] %v");
  }
}

void Log::write(Level level, std::string_view message, Fields fields) {
  if (!shows(level)) return;
  const bool json = format_ == LogFormat::kJson;
  std::string line = json ? "\"message\":" + quoted(message) : one_line(message);
  for (const LogField& field : fields) {
    if (is_empty(field)) continue;
    line += json ? ",\"" : " ";
    line += field.name;
    line += json ? "\":" : "=";
    line += value_of(field, format_);
  }
  logger_.log(level, line);
}

}  // namespace sightline
