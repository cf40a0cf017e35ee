#include "proto/json/generator_json.h"

#include <algorithm>
#include <array>
#include <utility>

#include "proto/json/point_rows.h"

namespace sightline {

namespace {

constexpr std::array<std::string_view, 20> kGeneratorKeys{
    "position", "forward", "look_at", "up",           "kind",       "range",    "fov_y",
    "extent_y", "width",   "height",  "poses",        "elevations", "azimuths", "points",
    "normals",  "count",   "seed",    "distribution", "camera",     "returns"};
enum Key : std::size_t {
  kPosition,
  kForward,
  kLookAt,
  kUp,
  kKind,
  kRange,
  kFovY,
  kExtentY,
  kWidth,
  kHeight,
  kPoses,
  kElevations,
  kAzimuths,
  kPoints,
  kNormals,
  kCount,
  kSeed,
  kDistribution,
  kCamera,
  kReturns,
};
constexpr std::size_t kPoseKeys = 4;
constexpr std::array<std::string_view, 6> kKinds{"pinhole", "orthographic", "equirectangular",
                                                 "lidar",   "hemisphere",   "camera"};
enum Kind : std::size_t {
  kPinhole,
  kOrthographic,
  kEquirectangular,
  kLidar,
  kHemisphere,
  kOfFile,
};

constexpr unsigned bits(std::initializer_list<Key> keys) {
  unsigned set = 0;
  for (const Key key : keys) set |= 1u << key;
  return set;
}
constexpr unsigned kPoseBits = (1u << kPoseKeys) - 1;
constexpr unsigned kPixels = bits({kWidth, kHeight});
/// By kind: what may stand there beside "kind" and "range", and what must.
constexpr std::array<unsigned, 6> kAllowed{
    kPoseBits | kPixels | bits({kFovY}),
    kPoseBits | kPixels | bits({kExtentY}),
    kPoseBits | kPixels,
    kPoseBits | bits({kPoses, kElevations, kAzimuths, kReturns}),
    bits({kPoints, kNormals, kCount, kSeed, kDistribution}),
    kPixels | bits({kCamera})};
constexpr std::array<unsigned, 6> kNeeded{kPixels,
                                          kPixels | bits({kExtentY}),
                                          kPixels,
                                          bits({kElevations, kAzimuths}),
                                          bits({kPoints, kNormals, kCount}),
                                          kPixels | bits({kCamera})};

constexpr std::size_t kFirstPoses = 64;

std::string about_key(std::size_t kind, std::string_view verb, std::size_t key) {
  std::string text = "a generator of kind \"";
  text.append(kKinds[kind])
      .append("\" ")
      .append(verb)
      .append(" \"")
      .append(kGeneratorKeys[key])
      .append("\"");
  return text;
}

/// The keys and kinds of a view.
constexpr unsigned kViewKeys =
    kPoseBits | kPixels | bits({kKind, kRange, kFovY, kExtentY, kCamera});
constexpr unsigned kViewKinds = 1u << kPinhole | 1u << kOrthographic | 1u << kOfFile;

}  // namespace

JsonPointer GeneratorReader::place_of(std::size_t key) const {
  return root().key(kGeneratorKeys[key]);
}

struct GeneratorReader::Parts {
  unsigned seen = 0;
  std::size_t kind = 0, distribution = 0;
  Pose pose;
  RayRange range;
  double fov_y = 60, extent_y = 1;
  std::uint64_t width = 0, height = 0, azimuths = 0, count = 0, seed = 0, returns = 1;
  std::vector<Pose> poses;
  std::vector<double> elevations;
  std::vector<Vec3d> points, normals;
  FileCamera camera;
};

bool GeneratorReader::too_many(const JsonPointer& place) {
  return reader_.fail(ErrorKind::kTooLarge, "RAYS_TOO_MANY",
                      "a request may hold " + std::to_string(most_) + " rays", place);
}

bool GeneratorReader::admit(std::uint64_t count, const JsonPointer& place) {
  if (!admit_) return true;
  const Status admitted = admit_(count);
  if (admitted) return true;
  const Error& error = admitted.error();
  return reader_.fail(error.kind, error.code, error.message, place);
}

bool GeneratorReader::read_numbers(JsonReader::Value value, const JsonPointer& place,
                                   std::size_t count, double* out) {
  std::size_t found = 0;
  const std::string expected = "an array of " + std::to_string(count) + " numbers";
  const auto read_one = [&](std::size_t i, JsonReader::Value number) {
    if (found == count) {
      return reader_.invalid("LENGTH_WRONG", "expected " + expected + ", found more", place);
    }
    return reader_.read_number(number, out[found++], [&] { return JsonPointer(place).index(i); });
  };
  if (!reader_.read_array(value, expected, place, read_one)) return false;
  return found == count ||
         reader_.invalid("LENGTH_WRONG",
                         "expected " + expected + ", found " + std::to_string(found), place);
}

bool GeneratorReader::read_pose_part(std::size_t which, JsonReader::Value value,
                                     const JsonPointer& place, Pose& pose) {
  double v[3] = {};
  if (!read_numbers(value, JsonPointer(place).key(kGeneratorKeys[which]), 3, v)) return false;
  const Vec3d vector{v[0], v[1], v[2]};
  // "look_at" is kept in forward until the position is known too.
  (which == kPosition ? pose.position : which == kUp ? pose.up : pose.forward) = vector;
  return true;
}

bool GeneratorReader::read_pose(JsonReader::Value value, const JsonPointer& place, Pose& pose) {
  JsonReader::Object object;
  if (value.get_object().get(object) != simdjson::SUCCESS) {
    return reader_.wrong(value, place, "an object");
  }
  unsigned seen = 0;
  for (auto entry : object) {
    JsonReader::Field field;
    if (const auto code = std::move(entry).get(field); code != simdjson::SUCCESS) {
      return reader_.check_end(code, [&] { return JsonPointer(place); });
    }
    std::size_t which = 0;
    if (!reader_.read_key(field, kGeneratorKeys, kPoseBits, place, which) ||
        !reader_.mark_seen(1u << which, seen, JsonPointer(place).key(kGeneratorKeys[which])) ||
        !read_pose_part(which, field.value(), place, pose)) {
      return false;
    }
  }
  return finish_pose(seen, place, pose);
}

bool GeneratorReader::finish_pose(unsigned seen, const JsonPointer& place, Pose& pose) {
  if ((seen & bits({kForward, kLookAt})) == bits({kForward, kLookAt})) {
    return reader_.invalid("KEYS_MIXED", "a pose has \"forward\" or \"look_at\", not both", place);
  }
  if ((seen & bits({kLookAt})) != 0) {
    for (int k = 0; k < 3; ++k) pose.forward[k] -= pose.position[k];
  }
  return true;
}

bool GeneratorReader::read_part(std::size_t which, JsonReader::Value value, Parts& parts) {
  const JsonPointer place = place_of(which);
  const auto too_many_entries = [&](const JsonPointer& entry) { return too_many(entry); };
  const auto number = [&](double& out) {
    return reader_.read_number(value, out, [&] { return JsonPointer(place); });
  };
  switch (which) {
    case kKind:
      return reader_.read_word(value, kKinds, parts.kind, place);
    case kRange:
      return read_range(value, place, parts.range);
    case kFovY:
      if (!number(parts.fov_y)) return false;
      return (parts.fov_y > 0 && parts.fov_y < 180) ||
             reader_.invalid("NUMBER_OUT_OF_RANGE", "expected degrees above 0 and below 180",
                             place);
    case kExtentY:
      if (!number(parts.extent_y)) return false;
      return parts.extent_y > 0 ||
             reader_.invalid("NUMBER_OUT_OF_RANGE", "expected a number above 0", place);
    case kWidth:
      return reader_.read_count(value, most_, parts.width, place);
    case kHeight:
      return reader_.read_count(value, most_, parts.height, place);
    case kPoses:
      return reader_.read_array(value, "an array of poses", place,
                                [&](std::size_t i, JsonReader::Value entry) {
                                  const JsonPointer pose_place = JsonPointer(place).index(i);
                                  if (i == most_) return too_many(pose_place);
                                  // Three bytes, "{},", ask for a whole pose.
                                  if (i == parts.poses.capacity()) {
                                    const std::size_t room = std::max(kFirstPoses, 2 * i);
                                    if (!admit(room, place)) return false;
                                    parts.poses.reserve(room);
                                  }
                                  return read_pose(entry, pose_place, parts.poses.emplace_back());
                                });
    case kElevations:
      return reader_.read_array(
          value, "an array of degrees", place, [&](std::size_t i, JsonReader::Value entry) {
            const JsonPointer entry_place = JsonPointer(place).index(i);
            if (i == most_) return too_many(entry_place);
            return reader_.read_number(entry, parts.elevations.emplace_back(),
                                       [&] { return JsonPointer(entry_place); });
          });
    case kAzimuths:
      return reader_.read_count(value, most_, parts.azimuths, place);
    case kPoints:
      return read_points(reader_, value, place, most_, parts.points, too_many_entries);
    case kNormals:
      return read_points(reader_, value, place, most_, parts.normals, too_many_entries);
    case kCount:
      return reader_.read_count(value, most_, parts.count, place);
    case kSeed:
      return reader_.read_count(value, std::numeric_limits<std::uint64_t>::max(), parts.seed,
                                place);
    case kDistribution: {
      constexpr std::array<std::string_view, 2> kWords{"cosine", "uniform"};
      return reader_.read_word(value, kWords, parts.distribution, place);
    }
    case kReturns:
      if (!reader_.read_count(value, most_, parts.returns, place)) return false;
      return parts.returns > 0 ||
             reader_.invalid("NUMBER_OUT_OF_RANGE", "expected a number from 1 on", place);
    case kCamera:
      return read_camera(value, place, parts.camera);
    default:
      return read_pose_part(which, value, root(), parts.pose);
  }
}

bool GeneratorReader::read_camera(JsonReader::Value value, const JsonPointer& place,
                                  FileCamera& camera) {
  std::string_view name;
  if (value.get_string().get(name) == simdjson::SUCCESS) {
    camera.name = name;
    return true;
  }
  std::uint64_t index = 0;
  if (!reader_.read_count(value, std::numeric_limits<std::uint32_t>::max(), index, place))
    return false;
  camera.index = static_cast<std::uint32_t>(index);
  return true;
}

bool GeneratorReader::read_range(JsonReader::Value value, const JsonPointer& place,
                                 RayRange& range) {
  constexpr std::string_view kExpected = "an array of two numbers, the second or null";
  std::size_t found = 0;
  const auto read_one = [&](std::size_t i, JsonReader::Value number) {
    const auto number_place = [&] { return JsonPointer(place).index(i); };
    if (++found == 1) return reader_.read_number(number, range.tmin, number_place);
    if (found == 2) {
      return reader_.read_number_or_null(number, std::numeric_limits<double>::infinity(),
                                         range.tmax, number_place);
    }
    return reader_.invalid("LENGTH_WRONG", "expected two numbers, found more", place);
  };
  if (!reader_.read_array(value, kExpected, place, read_one)) return false;
  if (found != 2) return reader_.invalid("LENGTH_WRONG", "expected two numbers", place);
  return range.tmin <= range.tmax ||
         reader_.invalid("RAY_LIMITS_REVERSED", "the first must not be larger than the second",
                         place);
}

bool GeneratorReader::read(JsonReader::Value value, RayGenerator& generator) {
  JsonReader::Object object;
  if (value.get_object().get(object) != simdjson::SUCCESS) {
    return reader_.wrong(value, root(), "an object");
  }
  Parts parts;
  for (auto entry : object) {
    JsonReader::Field field;
    if (const auto code = std::move(entry).get(field); code != simdjson::SUCCESS) {
      return reader_.check_end(code, [&] { return root(); });
    }
    std::size_t which = 0;
    const unsigned known = is_view_ ? kViewKeys : (1u << kGeneratorKeys.size()) - 1;
    if (!reader_.read_key(field, kGeneratorKeys, known, root(), which) ||
        !reader_.mark_seen(1u << which, parts.seen, place_of(which)) ||
        !read_part(which, field.value(), parts)) {
      return false;
    }
  }
  if ((parts.seen & bits({kKind})) == 0) {
    return reader_.invalid("KEY_MISSING", "needs \"kind\"", root());
  }
  if (is_view_ && (kViewKinds >> parts.kind & 1u) == 0) {
    return reader_.invalid("VIEW_KIND", "a view is what a pinhole or an orthographic camera sees",
                           place_of(kKind));
  }
  for (std::size_t key = 0; key < kGeneratorKeys.size(); ++key) {
    const bool stands = (parts.seen >> key & 1u) != 0;
    if (stands && key != kKind && key != kRange && (kAllowed[parts.kind] >> key & 1u) == 0) {
      return reader_.invalid("KEY_UNKNOWN", about_key(parts.kind, "has no", key), place_of(key));
    }
    if (!stands && (kNeeded[parts.kind] >> key & 1u) != 0) {
      return reader_.invalid("KEY_MISSING", about_key(parts.kind, "needs", key), root());
    }
  }
  return finish_pose(parts.seen, root(), parts.pose) && assemble(parts, generator);
}

bool GeneratorReader::assemble(Parts& parts, RayGenerator& generator) {
  generator.range = parts.range;
  generator.returns = parts.returns;
  switch (parts.kind) {
    case kPinhole:
      generator.kind = Pinhole{parts.pose, parts.fov_y, parts.width, parts.height};
      break;
    case kOrthographic:
      generator.kind = Orthographic{parts.pose, parts.extent_y, parts.width, parts.height};
      break;
    case kEquirectangular:
      generator.kind = Equirectangular{parts.pose, parts.width, parts.height};
      break;
    case kLidar: {
      const bool many = (parts.seen & bits({kPoses})) != 0;
      if (many && (parts.seen & kPoseBits) != 0) {
        return reader_.invalid("KEYS_MIXED", "poses stand in \"poses\", or there is one pose",
                               place_of(kPoses));
      }
      if (!many) parts.poses = {parts.pose};
      generator.kind = Lidar{std::move(parts.poses), std::move(parts.elevations), parts.azimuths};
      break;
    }
    case kOfFile: {
      if (!find_camera_)
        return reader_.invalid("CAMERA_UNKNOWN", "there is no scene here", place_of(kCamera));
      FileCamera camera = parts.camera;
      camera.width = parts.width;
      camera.height = parts.height;
      auto found = find_camera_(camera);
      if (!found)
        return reader_.invalid(found.error().code, found.error().message, place_of(kCamera));
      generator.kind = std::move(found->kind);
      if ((parts.seen & bits({kRange})) == 0) generator.range = found->range;
      break;
    }
    default:
      if (parts.points.size() != parts.normals.size()) {
        return reader_.invalid("LENGTH_WRONG",
                               "has " + std::to_string(parts.normals.size()) + " normals for " +
                                   std::to_string(parts.points.size()) + " points",
                               place_of(kNormals));
      }
      generator.kind = Hemisphere{std::move(parts.points), std::move(parts.normals), parts.count,
                                  parts.seed, parts.distribution == 1};
  }
  return ray_count(generator) <= most_ / generator.returns || too_many(root());
}

}  // namespace sightline
