#include "proto/binary/point_binary.h"

#include <cmath>

#include "proto/binary/binary_answer.h"
#include "proto/binary/binary_columns.h"
#include "proto/json/json_pointer.h"

namespace sightline {
namespace {

constexpr BinaryKind kPoints{"SLP1", "points", "POINTS_TOO_MANY", 1,
                             [](std::uint32_t) { return std::size_t{3}; }};

void announce_trust(BinaryAnswer& answer, const InsideColumns& columns) {
  answer.announce<std::uint8_t>("reliable", columns.reliable.size());
  if (columns.by_winding) answer.announce<std::int64_t>("winding", columns.winding.size());
}

void write_trust(BinaryAnswer& answer, const InsideColumns& columns) {
  answer.next<std::uint8_t>([&](std::size_t i, std::uint32_t) { return columns.reliable[i]; });
  if (!columns.by_winding) return;
  answer.next<std::int64_t>([&](std::size_t i, std::uint32_t) { return columns.winding[i]; });
}

}  // namespace

Result<PointQuery> decode_points_binary(std::string_view body, const PointJsonRules& rules) {
  const auto header = read_whole_header(body, kPoints, rules.max_points);
  if (!header) return header.error();
  PointJsonRules option_rules = rules;
  option_rules.has_points = false;
  option_rules.default_fields = kDefaultBinaryNearestFields;
  std::string options = options_of(body, *header);
  auto query = decode_points(options, option_rules);
  if (!query) return query;
  query->options.layout = AnswerLayout::kBinary;

  query->points.resize(header->rows);
  UnsetColumn<double> column(header->rows);
  for (int k = 0; k < 3; ++k) {
    read_column(body, *header, static_cast<std::size_t>(k), column);
    for (std::size_t i = 0; i < column.size(); ++i) query->points[i][k] = column[i];
  }
  for (std::size_t i = 0; i < query->points.size(); ++i) {
    const Vec3d& p = query->points[i];
    if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) continue;
    return Error{ErrorKind::kInvalid, "POINT_NOT_FINITE", "a point must be three finite numbers",
                 JsonPointer().key("points").index(i).text()};
  }
  return query;
}

std::string encode_inside_binary(const InsideColumns& columns) {
  BinaryAnswer answer;
  answer.announce<std::uint8_t>("inside", columns.inside.size());
  announce_trust(answer, columns);
  answer.begin();
  answer.next<std::uint8_t>([&](std::size_t i, std::uint32_t) -> std::uint8_t {
    return columns.on_surface[i] != 0 ? 255 : columns.inside[i];
  });
  write_trust(answer, columns);
  return answer.take();
}

std::string encode_signed_distances_binary(const InsideColumns& columns,
                                           std::span<const double> distance) {
  BinaryAnswer answer;
  answer.announce<double>("distance", distance.size());
  announce_trust(answer, columns);
  answer.begin();
  answer.next<double>([&](std::size_t i, std::uint32_t) { return distance[i]; });
  write_trust(answer, columns);
  return answer.take();
}

}  // namespace sightline
