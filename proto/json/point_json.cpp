#include "proto/json/point_json.h"

#include <array>
#include <cmath>

#include "proto/json/answer_members.h"
#include "proto/json/json_writer.h"
#include "proto/json/point_rows.h"
#include "proto/json/ray_reader.h"

namespace sightline {
namespace {

constexpr std::array<std::string_view, 8> kPointKeys{
    "points", "method", "max_distance", "count", "normals", "seed", "distribution", "min_distance"};
constexpr unsigned kDirectionKeys = 0xf0u;

class PointReader : public RayReader {
 public:
  explicit PointReader(const PointJsonRules& rules)
      : RayReader({.has_fields = rules.has_fields,
                   .has_rays = false,
                   .default_fields = rules.default_fields,
                   .known_fields = kNearestFields,
                   .has_marks = false,
                   .has_culling = false,
                   // A body is cut open where single triangles are excluded.
                   .has_triangles = !rules.has_method}),
        rules_(rules) {
    points_.count = rules.default_count;
    points_.asks_rays = rules.has_directions;
  }

  Result<PointQuery> read_all(std::string& body) {
    Result<QueryOptions> options = read_options(body);
    if (!options) return std::move(options).error();
    points_.options = std::move(*options);
    return std::move(points_);
  }

 private:
  std::span<const std::string_view> more_keys() const override {
    static_assert(kPointKeys.size() <= kMostMoreKeys);
    return kPointKeys;
  }
  unsigned known_more_keys() const override {
    return (rules_.has_points ? 1u : 0u) | (rules_.has_method ? 2u : 0u) |
           (rules_.has_max_distance ? 4u : 0u) | (rules_.has_count ? 8u : 0u) |
           (rules_.has_directions ? kDirectionKeys : 0u);
  }

  bool read_more(std::size_t which, Value value) override {
    const JsonPointer place = JsonPointer().key(kPointKeys[which]);
    switch (which) {
      case 0:
      case 4:
        (which == 0 ? has_points_ : points_.has_normals) = true;
        return read_points(
            *this, value, place, rules_.max_points, which == 0 ? points_.points : points_.normals,
            [&](const JsonPointer& point_place) {
              return fail(ErrorKind::kTooLarge, "POINTS_TOO_MANY",
                          "a request may hold " + std::to_string(rules_.max_points) + " points",
                          point_place);
            });
      case 1: {
        // In the order of InsideMethod.
        constexpr std::array<std::string_view, 3> kMethods{"parity", "winding", "solid_angle"};
        std::size_t word = 0;
        if (!read_word(value, kMethods, word, place)) return false;
        points_.method = static_cast<InsideMethod>(word);
        return true;
      }
      case 5:
        return read_count(value, std::numeric_limits<std::uint64_t>::max(), points_.seed, place);
      case 6: {
        constexpr std::array<std::string_view, 2> kDistributions{"cosine", "uniform"};
        std::size_t word = 0;
        if (!read_word(value, kDistributions, word, place)) return false;
        points_.uniform = word == 1;
        return true;
      }
      case 7:
        return read_number(value, points_.min_distance, [&] { return JsonPointer(place); }) &&
               check_distance(points_.min_distance, place);
      case 2:
        if (!read_number_or_null(value, std::numeric_limits<double>::infinity(),
                                 points_.max_distance, [&] { return JsonPointer(place); })) {
          return false;
        }
        return check_distance(points_.max_distance, place);
      default:
        if (!read_count(value, rules_.max_count, points_.count, place)) return false;
        return points_.count > 0 || invalid("COUNT_ZERO", "must be 1 at least", place);
    }
  }

  bool check_distance(double distance, const JsonPointer& place) {
    return distance >= 0 || invalid("DISTANCE_NEGATIVE", "a distance must not be negative", place);
  }

  bool finish_more() override {
    if (!has_points_ && rules_.has_points) return invalid("KEY_MISSING", "needs \"points\"", {});
    if (points_.min_distance > points_.max_distance) {
      return invalid("RAY_LIMITS_REVERSED", "min_distance is greater than max_distance",
                     JsonPointer().key("min_distance"));
    }
    return true;
  }

  PointJsonRules rules_;
  bool has_points_ = false;
  PointQuery points_;
};

/// {"method":".."
JsonWriter begin_answer(const InsideColumns& columns, std::size_t bytes_each) {
  JsonWriter out(160 + columns.reliable.size() * bytes_each);
  out.raw(columns.method == InsideMethod::kParity    ? "{\"method\":\"parity\""
          : columns.method == InsideMethod::kWinding ? "{\"method\":\"winding\""
                                                     : "{\"method\":\"solid_angle\"");
  return out;
}

template <class Write>
void write_list(JsonWriter& out, std::string_view name, std::size_t count, Write write) {
  out.raw(",\"");
  out.raw(name);
  out.raw("\":[");
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) out.raw(',');
    write(i);
  }
  out.raw(']');
}

void write_flags(JsonWriter& out, std::string_view name, std::span<const std::uint8_t> flags) {
  write_list(out, name, flags.size(), [&](std::size_t i) { out.boolean(flags[i] != 0); });
}

std::string finish_answer(JsonWriter& out, const InsideColumns& columns) {
  if (columns.method == InsideMethod::kWinding) {
    write_list(out, "winding", columns.winding.size(),
               [&](std::size_t i) { out.raw(std::to_string(columns.winding[i])); });
  }
  if (columns.method == InsideMethod::kSolidAngle) {
    write_list(out, "winding", columns.generalized.size(),
               [&](std::size_t i) { out.number(columns.generalized[i]); });
    write_list(out, "error", columns.error.size(),
               [&](std::size_t i) { out.number(columns.error[i]); });
  }
  out.raw('}');
  std::string text = out.take();
  if (columns.open_edges > 0) add_member(text, "unreliable", encode_unreliable(columns.open_edges));
  return text;
}

}  // namespace

Result<PointQuery> decode_points(std::string& body, const PointJsonRules& rules) {
  auto query = PointReader(rules).read_all(body);
  if (query && rules.has_directions && rules.has_points) {
    if (Status status = finish_normals(*query); !status) return status.error();
  }
  return query;
}

std::string encode_inside(const InsideColumns& columns) {
  JsonWriter out = begin_answer(columns, 20);
  write_list(out, "inside", columns.inside.size(), [&](std::size_t i) {
    if (columns.on_surface[i] != 0) return out.raw("null");
    out.boolean(columns.inside[i] != 0);
  });
  write_flags(out, "on_surface", columns.on_surface);
  write_flags(out, "reliable", columns.reliable);
  return finish_answer(out, columns);
}

std::string encode_signed_distances(const InsideColumns& columns,
                                    std::span<const double> distance) {
  JsonWriter out = begin_answer(columns, 26);
  write_list(out, "distance", distance.size(), [&](std::size_t i) { out.number(distance[i]); });
  write_flags(out, "reliable", columns.reliable);
  return finish_answer(out, columns);
}

Status finish_normals(PointQuery& query) {
  const JsonPointer place = JsonPointer().key("normals");
  if (!query.has_normals) query.normals.assign(query.points.size(), {0, 1, 0});
  if (query.normals.size() != query.points.size()) {
    return Error{ErrorKind::kInvalid, "LENGTH_WRONG",
                 "has " + std::to_string(query.normals.size()) + " normals for " +
                     std::to_string(query.points.size()) + " points",
                 place.text()};
  }
  for (std::size_t i = 0; i < query.normals.size(); ++i) {
    if (query.normals[i] != Vec3d{}) continue;
    return Error{ErrorKind::kInvalid, "NORMAL_ZERO", "a normal must not be zero",
                 JsonPointer(place).index(i).text()};
  }
  return success();
}

std::string encode_sky(std::uint64_t directions, std::span<const std::uint64_t> counts) {
  JsonWriter out(64 + counts.size() * 40);
  out.raw("{\"directions\":" + std::to_string(directions));
  write_list(out, "counts", counts.size(),
             [&](std::size_t i) { out.raw(std::to_string(counts[i])); });
  write_list(out, "ratios", counts.size(), [&](std::size_t i) {
    out.number(static_cast<double>(counts[i]) / static_cast<double>(directions));
  });
  out.raw('}');
  return out.take();
}

std::string encode_unreliable(std::uint64_t open_edges) {
  return "{\"reason\":\"OPEN_EDGES\",\"open_edges\":" + std::to_string(open_edges) + "}";
}

}  // namespace sightline
