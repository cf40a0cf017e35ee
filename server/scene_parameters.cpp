#include "server/scene_parameters.h"

#include <algorithm>
#include <charconv>
#include <string_view>

namespace sightline {
namespace {

template <class Number>
std::optional<Number> parse(std::string_view text) {
  Number value{};
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || last != end) return std::nullopt;
  return value;
}

/// Digits with a fraction at most; a NaN is no number of seconds.
std::optional<std::chrono::milliseconds> parse_wait(std::string_view text) {
  const auto seconds = parse<double>(text);
  if (!seconds || !(*seconds >= 0 && *seconds <= static_cast<double>(kLongestWait.count()))) {
    return std::nullopt;
  }
  return std::chrono::milliseconds(static_cast<std::int64_t>(*seconds * 1000));
}

/// One "name=value". False when it is not known, not good, or there already.
bool take(std::string_view part, KnownParameters known, SceneParameters& parameters) {
  constexpr std::string_view kScene = "scene=", kWait = "wait=";
  if (part.starts_with(kWait) && !parameters.wait) {
    parameters.wait = parse_wait(part.substr(kWait.size()));
    return parameters.wait.has_value();
  }
  const bool has_scene = known == KnownParameters::kSceneAndWait;
  if (part.starts_with(kScene) && has_scene && !parameters.choice.scene) {
    parameters.choice.scene = parse<std::uint32_t>(part.substr(kScene.size()));
    return parameters.choice.scene.has_value();
  }
  return false;
}

}  // namespace

bool read_parameters(Exchange& exchange, KnownParameters known, SceneParameters& parameters) {
  std::string_view query = exchange.request.target;
  query.remove_prefix(std::min(query.find('?'), query.size()));
  while (!query.empty()) {
    query.remove_prefix(1);  // the '?' or '&'
    const std::string_view part = query.substr(0, query.find('&'));
    query.remove_prefix(part.size());
    if (part.empty() || take(part, known, parameters)) continue;
    std::string detail = "the query parameters here are ";
    if (known == KnownParameters::kSceneAndWait) {
      detail += "scene=N with the number of a scene of the file in digits and ";
    }
    detail += "wait=SECONDS from 0 to 3600, each at most once; there is no other separator than &";
    exchange.reply_problem(422, "QUERY_INVALID", std::move(detail));
    return false;
  }
  return true;
}

}  // namespace sightline
