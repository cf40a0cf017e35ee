#pragma once
/// Reads points from a JSON body: [[x,y,z],...]. For files of this room that use simdjson.

#include <string>

#include "core/query/ray_batch.h"
#include "proto/json/json_reader.h"

namespace sightline {

/// Appends the points to `points`, a container of Vec3d. If there are more than `most`, calls
/// too_many(place), which sets an error of the reader and returns false. Returns false if the
/// reader has an error; `points` then has those before it. Errors: those of read_array and
/// read_number, and LENGTH_WRONG.
template <class Points, class TooMany>
bool read_points(JsonReader& reader, JsonReader::Value value, const JsonPointer& place,
                 std::size_t most, Points& points, TooMany too_many) {
  const auto read_point = [&](std::size_t i, JsonReader::Value entry) {
    const JsonPointer point_place = JsonPointer(place).index(i);
    if (i == most) return too_many(point_place);
    Vec3d point;
    int count = 0;
    const auto read_coordinate = [&](std::size_t k, JsonReader::Value number) {
      if (count == 3) {
        return reader.invalid("LENGTH_WRONG", "expected three numbers, found more", point_place);
      }
      return reader.read_number(number, point[count++],
                                [&] { return JsonPointer(point_place).index(k); });
    };
    if (!reader.read_array(entry, "an array of three numbers", point_place, read_coordinate)) {
      return false;
    }
    if (count != 3) {
      return reader.invalid("LENGTH_WRONG",
                            "expected three numbers, found " + std::to_string(count), point_place);
    }
    points.push_back(point);
    return true;
  };
  return reader.read_array(value, "an array of points", place, read_point);
}

}  // namespace sightline

// Tests: tests/unit/proto/ray_json_test.cpp
