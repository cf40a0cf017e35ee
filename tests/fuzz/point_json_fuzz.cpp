// Bodies of points: an error with a place, or points that another parser reads alike.
// Run:  scripts/stress.sh fuzz --target point_json_fuzz

#include <string>

#include "proto/json/point_json.h"
#include "tests/fuzz/body_check.h"

using namespace sightline;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using fuzz::require;
  const std::string sent(reinterpret_cast<const char*>(data), size);
  std::string body = sent;
  const PointJsonRules rules{.max_points = 64,
                             .has_method = size % 2 == 0,
                             .has_max_distance = size % 3 != 0,
                             .has_count = size % 2 == 1,
                             .has_fields = size % 2 == 1,
                             .has_directions = size % 5 < 2};
  const auto query = decode_points(body, rules);
  require(body == sent, "the body is only read");
  if (!query) {
    fuzz::check_error(query.error());
    return 0;
  }
  const auto document = nlohmann::json::parse(sent, nullptr, false);
  require(document.is_object(), "what is accepted is JSON");
  const auto& points = document["points"];
  require(points.size() == query->points.size() && points.size() <= 64, "as many points");
  for (std::size_t i = 0; i < points.size(); ++i) {
    require(points[i].size() == 3, "a point is three numbers");
    for (int k = 0; k < 3; ++k) {
      require(fuzz::same(points[i][static_cast<std::size_t>(k)], query->points[i][k]),
              "points read alike");
    }
  }
  require(query->count > 0 && query->count <= rules.max_count, "counts are in range");
  require(!rules.has_directions || query->normals.size() == points.size(), "as many normals");
  require(query->min_distance >= 0 && query->min_distance <= query->max_distance,
          "distances are in order");
  require(query->max_distance >= 0, "a distance is none below zero");
  return 0;
}
