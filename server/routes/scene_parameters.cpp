#include "server/routes/scene_parameters.h"

#include <charconv>
#include <string_view>

#include "server/http/query_parameters.h"

namespace sightline {
namespace {

/// Digits with a fraction at most; a NaN is no number of seconds.
std::optional<std::chrono::milliseconds> parse_wait(std::string_view text) {
  double seconds = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, seconds);
  const bool good = error == std::errc() && last == end && seconds >= 0 &&
                    seconds <= static_cast<double>(kLongestWait.count());
  if (!good) return std::nullopt;
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

}  // namespace

bool read_parameters(Exchange& exchange, KnownParameters known, SceneParameters& parameters) {
  const auto given = known == KnownParameters::kSceneAndWait
                         ? QueryParameters::read(exchange, {"scene", "wait"})
                         : QueryParameters::read(exchange, {"wait"});
  if (!given) return false;
  if (given->text("scene")) {
    std::uint64_t scene = 0;
    if (!given->number(exchange, "scene", UINT32_MAX, scene)) return false;
    parameters.choice.scene = static_cast<std::uint32_t>(scene);
  }
  if (const auto text = given->text("wait")) {
    parameters.wait = parse_wait(*text);
    if (!parameters.wait) {
      exchange.reply_problem(422, "QUERY_INVALID", "wait is a number of seconds from 0 to 3600");
      return false;
    }
  }
  return true;
}

}  // namespace sightline
