#include "proto/json/number_rows.h"

#include <array>
#include <string>

namespace sightline {

bool read_numbers(JsonReader& reader, JsonReader::Value value, const JsonPointer& place,
                  double* out, int count, std::optional<double> open) {
  const std::string word = count == 3 ? "three" : "four";
  int found = 0;
  const auto read_one = [&](std::size_t i, JsonReader::Value number) {
    const auto number_place = [&] { return JsonPointer(place).index(i); };
    if (found == count) {
      return reader.invalid("LENGTH_WRONG", "expected " + word + " numbers, found more", place);
    }
    double& slot = out[found++];
    return open ? reader.read_number_or_null(number, *open, slot, number_place)
                : reader.read_number(number, slot, number_place);
  };
  if (!reader.read_array(value, "an array of " + word + " numbers", place, read_one)) return false;
  if (found == count) return true;
  return reader.invalid("LENGTH_WRONG",
                        "expected " + word + " numbers, found " + std::to_string(found), place);
}

bool read_vector(JsonReader& reader, JsonReader::Value value, const JsonPointer& place,
                 Vec3d& out) {
  std::array<double, 3> numbers{};
  if (!read_numbers(reader, value, place, numbers.data(), 3)) return false;
  out = vector_of(numbers.data());
  return true;
}

bool read_axes(JsonReader& reader, JsonReader::Value value, const JsonPointer& place,
               std::array<Vec3d, 3>& out) {
  std::size_t axes = 0;
  const auto read_axis = [&](std::size_t i, JsonReader::Value axis) {
    if (i == 3) return reader.invalid("LENGTH_WRONG", "expected three axes, found more", place);
    ++axes;
    return read_vector(reader, axis, JsonPointer(place).index(i), out[i]);
  };
  if (!reader.read_array(value, "an array of three axes", place, read_axis)) return false;
  if (axes == 3) return true;
  return reader.invalid("LENGTH_WRONG", "expected three axes, found " + std::to_string(axes),
                        place);
}

}  // namespace sightline
