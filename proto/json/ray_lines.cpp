#include "proto/json/ray_lines.h"

#include <algorithm>

#include "proto/json/json_token.h"
#include "proto/json/plain_rays.h"
#include "proto/json/ray_reader.h"

namespace sightline {

/// Reads one line after the other with one parser.
class RayLines::Reader : private RayReader {
 public:
  using RayReader::RayReader;

  /// Appends the rays of the lines to those of the options, which have none.
  Result<RayQuery> read_lines(std::string_view text, std::size_t capacity, const RayQuery& options,
                              std::size_t first) {
    query_ = options;
    query_.layout = AnswerLayout::kLines;
    first_ray_ = first;
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      const std::string_view line = text.substr(0, end);
      const std::size_t room = capacity;
      const std::size_t step = std::min(end + 1, text.size());
      text.remove_prefix(step);
      capacity -= step;
      if (trim(line).empty()) continue;
      if (read_plain_line(line)) continue;
      const std::size_t ray = first + query_.rays.size();
      const auto place = [&] { return ray_place(ray); };
      if (!read_one(parser_, line, room, place, [&](Value value) { return read_row(value, ray); }))
        return error();
    }
    if (!check_limits_and_directions()) return error();
    finish_rays(query_);
    return std::move(query_);
  }

 private:
  /// The usual case.
  bool read_plain_line(std::string_view line) {
    const char* at = line.data();
    Ray ray;
    ray.tmin = default_tmin_;
    const char* const end = line.data() + line.size();
    if (!scan_plain_ray(at, ray) || at > end) return false;
    if (!trim({at, static_cast<std::size_t>(end - at)}).empty()) return false;
    push_row(ray, 0xffffffffu);
    return true;
  }

  simdjson::ondemand::parser parser_;
};

namespace {

/// The text inside of {"options": ... }, or nothing for another line.
std::string_view options_in(std::string_view line) {
  constexpr std::string_view kKey = "\"options\"";
  line = trim(line);
  if (!line.starts_with('{') || !line.ends_with('}')) return {};
  line = trim(line.substr(1, line.size() - 2));
  if (!line.starts_with(kKey)) return {};
  line = trim(line.substr(kKey.size()));
  return line.starts_with(':') ? trim(line.substr(1)) : std::string_view();
}

}  // namespace

RayLines::RayLines(const RayJsonRules& rules)
    : rules_(rules), reader_(std::make_unique<Reader>(rules)) {}
RayLines::~RayLines() = default;

Result<RayQuery> RayLines::decode(std::string& text) {
  text.reserve(text.size() + kRayJsonPadding);
  std::string_view lines = text;
  if (!begun_) {
    begun_ = true;
    RayJsonRules rules = rules_;
    rules.has_rays = false;
    const std::string_view line = lines.substr(0, std::min(lines.find('\n'), lines.size()));
    std::string options(options_in(line));
    if (!options.empty()) lines.remove_prefix(std::min(line.size() + 1, lines.size()));
    if (options.empty()) options = "{}";
    auto query = decode_rays(options, rules);
    if (!query) return query;
    options_ = std::move(*query);
  }
  const std::size_t before = text.size() - lines.size();
  auto query = reader_->read_lines(lines, text.capacity() - before, options_, seen_);
  if (query) seen_ += query->rays.size();
  return query;
}

}  // namespace sightline
