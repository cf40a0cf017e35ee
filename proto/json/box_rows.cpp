#include "proto/json/box_rows.h"

#include <algorithm>
#include <array>
#include <span>
#include <string>

#include "core/base/content_hash.h"
#include "core/base/infinity.h"
#include "core/query/view_frustum.h"
#include "proto/json/generator_json.h"
#include "proto/json/number_rows.h"

namespace sightline {

namespace {

constexpr std::array<std::string_view, 14> kBoxKeys{
    "min",  "max", "center", "half",    "rotation", "axes", "radius",
    "from", "to",  "planes", "corners", "view",     "hull", "cursor"};
constexpr unsigned kMin = 1u, kMax = 2u, kCenter = 4u, kHalf = 8u, kRotation = 16u, kAxes = 32u,
                   kRadius = 64u, kFrom = 128u, kTo = 256u, kPlanes = 512u, kEight = 1024u,
                   kView = 2048u, kHull = 4096u, kCursor = 8192u;
/// The keys of boxes, of all shapes, and of shapes with a cursor: by BoxRows::Takes.
constexpr std::array<unsigned, 3> kTaken{kRadius - 1, kCursor - 1, 2 * kCursor - 1};
constexpr unsigned kAnyPlanes = kPlanes | kEight | kView;
constexpr unsigned kCorners = kMin | kMax, kMiddle = kCenter | kHalf, kTurn = kRotation | kAxes;

JsonPointer box_place(std::size_t box) { return JsonPointer().key("boxes").index(box); }
JsonPointer part_place(std::size_t box, std::string_view part) {
  JsonPointer place = box_place(box);
  place.key(part);
  return place;
}

}  // namespace

struct BoxRows::Row {
  unsigned seen = 0;
  std::array<double, 3> min{}, max{}, center{}, half{}, from{}, to{};
  std::array<double, 4> rotation{};
  std::array<Vec3d, 3> axes{};
  double radius = 0;
  std::array<HalfSpace, ConvexRegion::kMostPlanes> planes{};
  std::size_t plane_count = 0;
  std::vector<Vec3d> hull;
};

std::uint64_t BoxRows::hash_of_shape(const Row& row) {
  ContentHash hash;
  const auto add = [&](const auto& numbers) { hash.add(std::as_bytes(std::span(numbers))); };
  const std::array<unsigned, 1> seen{row.seen & ~kCursor};
  add(seen);
  add(row.min);
  add(row.max);
  add(row.center);
  add(row.half);
  add(row.from);
  add(row.to);
  add(row.rotation);
  for (const Vec3d& axis : row.axes) add(std::array{axis.x, axis.y, axis.z});
  add(std::array{row.radius});
  for (std::size_t i = 0; i < row.plane_count; ++i) {
    const HalfSpace& plane = row.planes[i];
    add(std::array{plane.normal.x, plane.normal.y, plane.normal.z, plane.offset});
  }
  for (const Vec3d& p : row.hull) add(std::array{p.x, p.y, p.z});
  return hash.value();
}

bool BoxRows::read_part(std::size_t box, std::size_t which, JsonReader::Value value, Row& row) {
  const JsonPointer place = part_place(box, kBoxKeys[which]);
  switch (1u << which) {
    case kMin:
      return read_numbers(reader_, value, place, row.min.data(), 3, -kInf);
    case kMax:
      return read_numbers(reader_, value, place, row.max.data(), 3, kInf);
    case kCenter:
      return read_numbers(reader_, value, place, row.center.data(), 3);
    case kHalf:
      return read_numbers(reader_, value, place, row.half.data(), 3, kInf);
    case kRotation:
      return read_numbers(reader_, value, place, row.rotation.data(), 4);
    case kRadius:
      return reader_.read_number(value, row.radius, [&] { return JsonPointer(place); });
    case kFrom:
      return read_numbers(reader_, value, place, row.from.data(), 3);
    case kTo:
      return read_numbers(reader_, value, place, row.to.data(), 3);
    case kPlanes:
      return read_planes(value, place, row);
    case kEight:
      return read_corners(value, place, row);
    case kView:
      return read_view(value, place, row);
    case kHull:
      return read_hull(value, place, row);
    case kCursor:
      return read_cursor(value, place, box);
    default:
      return read_axes(reader_, value, place, row.axes);
  }
}

bool BoxRows::read_planes(JsonReader::Value value, const JsonPointer& place, Row& row) {
  const auto read_plane = [&](std::size_t i, JsonReader::Value plane) {
    const JsonPointer plane_place = JsonPointer(place).index(i);
    if (i == ConvexRegion::kMostPlanes) {
      return reader_.invalid("BOX_PLANES_COUNT", "a region has 1 to 32 planes", plane_place);
    }
    std::array<double, 4> numbers{};
    if (!read_numbers(reader_, plane, plane_place, numbers.data(), 4)) return false;
    row.planes[row.plane_count++] = {vector_of(numbers.data()), numbers[3]};
    return true;
  };
  return reader_.read_array(value, "an array of planes", place, read_plane);
}

bool BoxRows::read_hull(JsonReader::Value value, const JsonPointer& place, Row& row) {
  const auto read_point = [&](std::size_t i, JsonReader::Value point) {
    const JsonPointer point_place = JsonPointer(place).index(i);
    if (i == PointHull::kMostPoints) {
      return reader_.invalid("BOX_HULL_COUNT", "a hull has 1 to 256 points", point_place);
    }
    std::array<double, 3> numbers{};
    if (!read_numbers(reader_, point, point_place, numbers.data(), 3)) return false;
    row.hull.push_back(vector_of(numbers.data()));
    return true;
  };
  return reader_.read_array(value, "an array of points", place, read_point);
}

bool BoxRows::take_planes(const Result<std::vector<HalfSpace>>& planes, const JsonPointer& place,
                          Row& row) {
  if (!planes) return reader_.invalid(planes.error().code, planes.error().message, place);
  std::copy(planes->begin(), planes->end(), row.planes.begin());
  row.plane_count = planes->size();
  return true;
}

bool BoxRows::read_corners(JsonReader::Value value, const JsonPointer& place, Row& row) {
  std::array<Vec3d, 8> corners;
  std::size_t found = 0;
  const auto read_corner = [&](std::size_t i, JsonReader::Value corner) {
    if (i == 8) return reader_.invalid("LENGTH_WRONG", "expected eight corners, found more", place);
    ++found;
    std::array<double, 3> numbers{};
    if (!read_numbers(reader_, corner, JsonPointer(place).index(i), numbers.data(), 3)) {
      return false;
    }
    corners[i] = vector_of(numbers.data());
    return true;
  };
  if (!reader_.read_array(value, "an array of eight corners", place, read_corner)) return false;
  if (found != 8) {
    return reader_.invalid("LENGTH_WRONG", "expected eight corners, found " + std::to_string(found),
                           place);
  }
  return take_planes(frustum_of(corners), place, row);
}

bool BoxRows::read_view(JsonReader::Value value, const JsonPointer& place, Row& row) {
  RayGenerator camera;
  return GeneratorReader(reader_, find_camera_, place).read(value, camera) &&
         take_planes(view_frustum(camera), place, row);
}

bool BoxRows::read_cursor(JsonReader::Value value, const JsonPointer& place, std::size_t box) {
  std::string_view text;
  if (value.get_string().get(text) != simdjson::SUCCESS) {
    return reader_.wrong(value, place, "a text");
  }
  const std::optional<ListCursor> cursor = decode_cursor(text);
  if (!cursor) {
    return reader_.invalid("CURSOR_UNKNOWN", "this is no cursor that a list has ended with", place);
  }
  cursors_.resize(box);
  cursors_.push_back(*cursor);
  return true;
}

/// A sphere or a capsule.
bool BoxRows::finish_round(std::size_t box, const Row& row, BoxBatch& boxes) {
  const unsigned seen = row.seen & ~kCursor;
  forms_.push_back(Form::kOther);
  if (seen == (kCenter | kRadius)) {
    boxes.push_back(Sphere{vector_of(row.center.data()), row.radius});
    return true;
  }
  if (seen == (kFrom | kTo | kRadius)) {
    boxes.push_back(Capsule{vector_of(row.from.data()), vector_of(row.to.data()), row.radius});
    return true;
  }
  if ((seen & (kFrom | kTo)) != 0) {
    return (seen & ~(kFrom | kTo | kRadius)) != 0
               ? reader_.invalid("KEYS_MIXED",
                                 "a capsule has two ends, from and to, and a radius, nothing else",
                                 box_place(box))
               : reader_.invalid("KEY_MISSING", "a capsule needs from, to and a radius",
                                 box_place(box));
  }
  return (seen & ~(kCenter | kRadius)) != 0
             ? reader_.invalid("KEYS_MIXED", "a sphere has a center and a radius, nothing else",
                               box_place(box))
             : reader_.invalid("KEY_MISSING", "a sphere needs a center", box_place(box));
}

bool BoxRows::finish_row(std::size_t box, const Row& row, BoxBatch& boxes) {
  const unsigned seen = row.seen & ~kCursor;
  if ((seen & kAnyPlanes) != 0) {
    if (seen != kPlanes && seen != kEight && seen != kView) {
      return reader_.invalid("KEYS_MIXED",
                             "a region has planes, eight corners or a view, nothing else",
                             box_place(box));
    }
    forms_.push_back(Form::kOther);
    boxes.push_back(ConvexRegion{{row.planes.data(), row.plane_count}});
    return true;
  }
  if ((seen & kHull) != 0) {
    if (seen != kHull) {
      return reader_.invalid("KEYS_MIXED", "a hull has its points, nothing else", box_place(box));
    }
    forms_.push_back(Form::kOther);
    boxes.push_back(PointHull{row.hull});
    return true;
  }
  if ((seen & (kRadius | kFrom | kTo)) != 0) return finish_round(box, row, boxes);
  if ((seen & kCorners) != 0 && (seen & ~kCorners) != 0) {
    return reader_.invalid("KEYS_MIXED",
                           "a box has min and max, or center, half and rotation or axes, not both",
                           box_place(box));
  }
  if ((seen & kTurn) == kTurn) {
    return reader_.invalid("KEYS_MIXED", "a box has a rotation or axes, not both", box_place(box));
  }
  if (seen == kCorners) {
    forms_.push_back(Form::kCorners);
    boxes.push_back(Box3d{vector_of(row.min.data()), vector_of(row.max.data())});
    return true;
  }
  if ((seen & kMiddle) != kMiddle || (seen & kTurn) == 0) {
    return reader_.invalid("KEY_MISSING",
                           "a box needs min and max, or center, half and rotation or axes",
                           box_place(box));
  }
  OrientedBox oriented{vector_of(row.center.data()), vector_of(row.half.data()), {}};
  if ((seen & kAxes) != 0) {
    oriented.axes = row.axes;
  } else {
    const auto& q = row.rotation;
    if (!is_rotation(q[0], q[1], q[2], q[3])) {
      return reader_.invalid("BOX_ROTATION_NOT_UNIT", kRotationNotUnit,
                             part_place(box, "rotation"));
    }
    oriented.axes = rotated_axes(q[0], q[1], q[2], q[3]);
  }
  forms_.push_back((seen & kAxes) != 0 ? Form::kAxes : Form::kRotation);
  boxes.push_back(oriented);
  return true;
}

bool BoxRows::read_row(std::size_t box, JsonReader::Value value, BoxBatch& boxes) {
  if (box == most_) {
    return reader_.fail(ErrorKind::kTooLarge, "BOXES_TOO_MANY",
                        "a request may hold " + std::to_string(most_) + " boxes", box_place(box));
  }
  JsonReader::Object object;
  if (value.get_object().get(object) != simdjson::SUCCESS) {
    return reader_.wrong(value, box_place(box), "an object");
  }
  Row row;
  for (auto entry : object) {
    JsonReader::Field field;
    if (const auto code = std::move(entry).get(field); code != simdjson::SUCCESS) {
      return reader_.check_end(code, [&] { return box_place(box); });
    }
    std::size_t which = 0;
    if (!reader_.read_key(field, kBoxKeys, kTaken[static_cast<std::size_t>(takes_)], box_place(box),
                          which) ||
        !reader_.mark_seen(1u << which, row.seen, part_place(box, kBoxKeys[which])) ||
        !read_part(box, which, field.value(), row)) {
      return false;
    }
  }
  if (!finish_row(box, row, boxes)) return false;
  if (takes_ == Takes::kCursors) shape_hashes_.push_back(hash_of_shape(row));
  return true;
}

bool BoxRows::read(JsonReader::Value value, BoxBatch& boxes) {
  const auto read_one = [&](std::size_t i, JsonReader::Value row) {
    return read_row(i, row, boxes);
  };
  if (!reader_.read_array(value, "an array of boxes", JsonPointer().key("boxes"), read_one)) {
    return false;
  }
  if (!cursors_.empty()) cursors_.resize(boxes.size());
  BoxFault fault;
  if (check_boxes(boxes, fault)) return true;
  // Axes from a rotation are the rotation's fault; they have no place of their own.
  const bool turned =
      forms_[fault.box] == Form::kRotation && std::string_view(fault.part) == "axes";
  JsonPointer place = part_place(fault.box, turned ? "rotation" : fault.part);
  if (!turned && fault.component != BoxFault::kWhole) {
    place.index(static_cast<std::size_t>(fault.component));
  }
  return reader_.invalid(fault.code, fault.message, place);
}

}  // namespace sightline
