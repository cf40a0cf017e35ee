#include "proto/binary/point_binary.h"

#include <cmath>

#include "proto/binary/binary_answer.h"
#include "proto/binary/binary_columns.h"
#include "proto/json/json_pointer.h"

namespace sightline {
namespace {

constexpr std::uint32_t kNormalsFlag = 2;
constexpr BinaryKind kPlainPoints{"SLP1", "points", "POINTS_TOO_MANY", 1,
                                  [](std::uint32_t) { return std::size_t{3}; }};
constexpr BinaryKind kDirectedPoints{
    "SLP1", "points", "POINTS_TOO_MANY", 3, [](std::uint32_t flags) {
      return (flags & kNormalsFlag) != 0 ? std::size_t{6} : std::size_t{3};
    }};

/// Reads three columns from `first` on as points. Errors: POINT_NOT_FINITE, below `key`.
Status read_vectors(std::string_view body, const BinaryHeader& header, std::size_t first,
                    std::string_view key, Column<Vec3d>& out) {
  out.resize(header.rows);
  UnsetColumn<double> column(header.rows);
  for (int k = 0; k < 3; ++k) {
    read_column(body, header, first + static_cast<std::size_t>(k), column);
    for (std::size_t i = 0; i < column.size(); ++i) out[i][k] = column[i];
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (std::isfinite(out[i].x) && std::isfinite(out[i].y) && std::isfinite(out[i].z)) continue;
    return Error{ErrorKind::kInvalid, "POINT_NOT_FINITE", "must be three finite numbers",
                 JsonPointer().key(key).index(i).text()};
  }
  return success();
}

void announce_trust(BinaryAnswer& answer, const InsideColumns& columns) {
  answer.announce<std::uint8_t>("reliable", columns.reliable.size());
  if (columns.method == InsideMethod::kWinding)
    answer.announce<std::int64_t>("winding", columns.winding.size());
  if (columns.method == InsideMethod::kSolidAngle) {
    answer.announce<double>("winding", columns.generalized.size());
    answer.announce<double>("error", columns.error.size());
  }
}

void write_trust(BinaryAnswer& answer, const InsideColumns& columns) {
  answer.next<std::uint8_t>([&](std::size_t i, std::uint32_t) { return columns.reliable[i]; });
  if (columns.method == InsideMethod::kWinding)
    answer.next<std::int64_t>([&](std::size_t i, std::uint32_t) { return columns.winding[i]; });
  if (columns.method != InsideMethod::kSolidAngle) return;
  answer.next<double>([&](std::size_t i, std::uint32_t) { return columns.generalized[i]; });
  answer.next<double>([&](std::size_t i, std::uint32_t) { return columns.error[i]; });
}

}  // namespace

Result<PointQuery> decode_points_binary(std::string_view body, const PointJsonRules& rules) {
  const auto header = read_whole_header(body, rules.has_directions ? kDirectedPoints : kPlainPoints,
                                        rules.max_points);
  if (!header) return header.error();
  PointJsonRules option_rules = rules;
  option_rules.has_points = false;
  option_rules.default_fields = kDefaultBinaryNearestFields;
  std::string options = options_of(body, *header);
  auto query = decode_points(options, option_rules);
  if (!query) return query;
  query->options.layout = AnswerLayout::kBinary;

  if (Status status = read_vectors(body, *header, 0, "points", query->points); !status) {
    return status.error();
  }
  query->has_normals = (header->flags & kNormalsFlag) != 0;
  if (query->has_normals) {
    if (Status status = read_vectors(body, *header, 3, "normals", query->normals); !status) {
      return status.error();
    }
  }
  if (rules.has_directions) {
    if (Status status = finish_normals(*query); !status) return status.error();
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

std::string encode_visibility_binary(const PointPairs& pairs,
                                     std::span<const std::uint8_t> visible) {
  const bool all = pairs.pairing == BoxPairing::kAll;
  BinaryAnswer answer;
  answer.announce<std::uint8_t>("visible", pairs.from.size(),
                                all ? static_cast<std::uint32_t>(pairs.to.size()) : 1);
  answer.begin();
  answer.next<std::uint8_t>(visible);
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
