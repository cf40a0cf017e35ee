#include "proto/json/generator_json.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include "proto/json/point_rows.h"

namespace sightline {

namespace {

constexpr std::array<std::string_view, 31> kGeneratorKeys{
    "position",   "forward",   "look_at", "up",           "kind",       "range",    "fov_y",
    "extent_y",   "width",     "height",  "poses",        "elevations", "azimuths", "points",
    "normals",    "count",     "seed",    "distribution", "camera",     "returns",  "fov_x",
    "intrinsics", "extrinsic", "crop",    "pixels",       "sector",     "firings",  "divergence",
    "samples",    "noise",     "dropout"};
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
  kFovX,
  kIntrinsics,
  kExtrinsic,
  kCrop,
  kPixelList,
  kSector,
  kFirings,
  kDivergence,
  kSamples,
  kNoise,
  kDropout,
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
constexpr unsigned kParts = kPixels | bits({kCrop, kPixelList});
constexpr unsigned kCameraBits = kPoseBits | kParts | bits({kExtrinsic});
/// By kind: what may stand there beside "kind" and "range", and what must.
constexpr std::array<unsigned, 6> kAllowed{
    kCameraBits | bits({kFovY, kFovX, kIntrinsics}),
    kCameraBits | bits({kExtentY}),
    kCameraBits,
    kPoseBits | bits({kPoses, kElevations, kAzimuths, kReturns, kSector, kFirings, kDivergence,
                      kSamples, kNoise, kDropout, kSeed}),
    bits({kPoints, kNormals, kCount, kSeed, kDistribution}),
    kParts | bits({kCamera})};
constexpr std::array<unsigned, 6> kNeeded{
    kPixels,           kPixels | bits({kExtentY}),        kPixels,
    bits({kAzimuths}), bits({kPoints, kNormals, kCount}), kPixels | bits({kCamera})};

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

/// Keys of which a generator has one at most.
struct Alternatives {
  unsigned keys;
  std::string_view message;
};
constexpr std::array<Alternatives, 3> kAlternatives{
    {{bits({kFovY, kFovX, kIntrinsics}),
      "a camera has \"fov_y\", \"fov_x\" or \"intrinsics\", not two of them"},
     {bits({kCrop, kPixelList}), "a camera has \"crop\" or \"pixels\", not both"},
     {bits({kElevations, kFirings}), "a lidar has \"elevations\" or \"firings\", not both"}}};

/// The pose of a matrix from the world to the camera, whose axes point right, down and forward.
/// Empty if its columns are no rotation, up to 2^-16 of their length, or its last row is not
/// 0, 0, 0, 1.
std::optional<Pose> pose_of(const std::array<std::array<double, 4>, 4>& m) {
  constexpr double kOff = 0x1p-16;
  if (m[3] != std::array<double, 4>{0, 0, 0, 1}) return std::nullopt;
  const auto dot = [&](std::size_t i, std::size_t k) {
    return m[i][0] * m[k][0] + m[i][1] * m[k][1] + m[i][2] * m[k][2];
  };
  double determinant = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(std::fabs(dot(i, k) - (i == k ? 1 : 0)) <= kOff)) return std::nullopt;
    }
    const std::size_t k = (i + 1) % 3, l = (i + 2) % 3;
    determinant += m[0][i] * (m[1][k] * m[2][l] - m[1][l] * m[2][k]);
  }
  if (determinant < 0) return std::nullopt;
  Pose pose;
  for (std::size_t k = 0; k < 3; ++k) {
    const int axis = static_cast<int>(k);
    pose.position[axis] = -(m[0][k] * m[0][3] + m[1][k] * m[1][3] + m[2][k] * m[2][3]);
    pose.forward[axis] = m[2][k];
    pose.up[axis] = -m[1][k];
  }
  return pose;
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
  double fov_y = 60, fov_x = 60, extent_y = 1;
  std::uint64_t width = 0, height = 0, azimuths = 0, count = 0, seed = 0, returns = 1;
  Intrinsics intrinsics;
  Crop crop;
  std::vector<Pixel> pixels;
  double from = 0, to = 360, divergence = 0, noise = 0, dropout = 0;
  std::uint64_t samples = 1;
  std::vector<Pose> poses;
  std::vector<Laser> lasers;
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
  // "look_at" is stored in forward until the position is known too.
  (which == kPosition ? pose.position : which == kUp ? pose.up : pose.forward) = vector;
  return true;
}

bool GeneratorReader::read_pose(JsonReader::Value value, const JsonPointer& place, Pose& pose) {
  unsigned seen = 0;
  const auto take = [&](std::size_t which, JsonReader::Value part, const JsonPointer&) {
    return read_pose_part(which, part, place, pose);
  };
  if (!reader_.read_members(value, kGeneratorKeys, kPoseBits, place, seen, take)) return false;
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
    case kFovX: {
      double& degrees = which == kFovY ? parts.fov_y : parts.fov_x;
      if (!number(degrees)) return false;
      return (degrees > 0 && degrees < 180) ||
             reader_.invalid("NUMBER_OUT_OF_RANGE", "expected degrees above 0 and below 180",
                             place);
    }
    case kIntrinsics:
      return read_intrinsics(value, place, parts.intrinsics);
    case kExtrinsic:
      return read_extrinsic(value, place, parts.pose);
    case kCrop:
      return read_crop(value, place, parts.crop);
    case kPixelList:
      return reader_.read_array(value, "an array of pixels [column, row]", place,
                                [&](std::size_t i, JsonReader::Value entry) {
                                  const JsonPointer entry_place = JsonPointer(place).index(i);
                                  if (i == most_) return too_many(entry_place);
                                  return read_pixel(entry, entry_place,
                                                    parts.pixels.emplace_back());
                                });
    case kSector: {
      double ends[2] = {};
      if (!read_numbers(value, place, 2, ends)) return false;
      parts.from = ends[0];
      parts.to = ends[1];
      return (parts.from < parts.to && parts.to - parts.from <= 360) ||
             reader_.invalid("NUMBER_OUT_OF_RANGE",
                             "expected two angles in degrees, the second larger by at most 360",
                             place);
    }
    case kFirings:
      return reader_.read_array(value, "an array of [azimuth, elevation]", place,
                                [&](std::size_t i, JsonReader::Value entry) {
                                  const JsonPointer entry_place = JsonPointer(place).index(i);
                                  if (i == most_) return too_many(entry_place);
                                  double angles[2] = {};
                                  if (!read_numbers(entry, entry_place, 2, angles)) return false;
                                  parts.lasers.push_back({angles[0], angles[1]});
                                  return true;
                                });
    case kDivergence:
      if (!number(parts.divergence)) return false;
      return (parts.divergence > 0 && parts.divergence < 90) ||
             reader_.invalid("NUMBER_OUT_OF_RANGE", "expected degrees above 0 and below 90", place);
    case kSamples:
      if (!reader_.read_count(value, most_, parts.samples, place)) return false;
      return parts.samples > 1 ||
             reader_.invalid("NUMBER_OUT_OF_RANGE", "expected a number from 2 on", place);
    case kNoise:
      if (!number(parts.noise)) return false;
      return parts.noise >= 0 ||
             reader_.invalid("NUMBER_OUT_OF_RANGE", "expected a number from 0 on", place);
    case kDropout:
      if (!number(parts.dropout)) return false;
      return (parts.dropout >= 0 && parts.dropout <= 1) ||
             reader_.invalid("NUMBER_OUT_OF_RANGE", "expected a number from 0 to 1", place);
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
            return reader_.read_number(entry, parts.lasers.emplace_back().elevation,
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

bool GeneratorReader::read_intrinsics(JsonReader::Value value, const JsonPointer& place,
                                      Intrinsics& lens) {
  double v[4] = {};
  if (!read_numbers(value, place, 4, v)) return false;
  lens = {v[0], v[1], v[2], v[3]};
  return (lens.fx > 0 && lens.fy > 0) ||
         reader_.invalid("NUMBER_OUT_OF_RANGE",
                         "expected [fx, fy, cx, cy] with focal lengths above 0", place);
}

bool GeneratorReader::read_extrinsic(JsonReader::Value value, const JsonPointer& place,
                                     Pose& pose) {
  std::array<std::array<double, 4>, 4> matrix{};
  std::size_t rows = 0;
  const auto read_row = [&](std::size_t i, JsonReader::Value row) {
    if (++rows > 4) return reader_.invalid("LENGTH_WRONG", "expected four rows, found more", place);
    return read_numbers(row, JsonPointer(place).index(i), 4, matrix[i].data());
  };
  if (!reader_.read_array(value, "an array of four rows of four numbers", place, read_row)) {
    return false;
  }
  if (rows != 4) return reader_.invalid("LENGTH_WRONG", "expected four rows", place);
  const auto found = pose_of(matrix);
  if (found) pose = *found;
  return found.has_value() ||
         reader_.invalid("GENERATOR_POSE",
                         "expected a rotation and a translation from the world to the camera, with "
                         "the last row 0, 0, 0, 1",
                         place);
}

bool GeneratorReader::read_counts(JsonReader::Value value, const JsonPointer& place,
                                  std::span<std::uint64_t* const> out) {
  std::size_t found = 0;
  const std::string expected = "an array of " + std::to_string(out.size()) + " numbers";
  const auto read_one = [&](std::size_t i, JsonReader::Value number) {
    if (++found > out.size()) {
      return reader_.invalid("LENGTH_WRONG", "expected " + expected + ", found more", place);
    }
    return reader_.read_count(number, kMostPixels, *out[i], JsonPointer(place).index(i));
  };
  if (!reader_.read_array(value, expected, place, read_one)) return false;
  return found == out.size() ||
         reader_.invalid("LENGTH_WRONG",
                         "expected " + expected + ", found " + std::to_string(found), place);
}

bool GeneratorReader::read_crop(JsonReader::Value value, const JsonPointer& place, Crop& crop) {
  const std::array<std::uint64_t*, 4> numbers{&crop.left, &crop.top, &crop.width, &crop.height};
  return read_counts(value, place, numbers);
}

bool GeneratorReader::read_pixel(JsonReader::Value value, const JsonPointer& place, Pixel& pixel) {
  const std::array<std::uint64_t*, 2> numbers{&pixel.column, &pixel.row};
  return read_counts(value, place, numbers);
}

bool GeneratorReader::check_parts_of_image(const Parts& parts) {
  const auto outside = [&](const JsonPointer& place) {
    return reader_.invalid("NUMBER_OUT_OF_RANGE",
                           "this is outside of the image of " + std::to_string(parts.width) +
                               " by " + std::to_string(parts.height) + " pixels",
                           place);
  };
  const Crop& crop = parts.crop;
  if (crop.left + crop.width > parts.width || crop.top + crop.height > parts.height) {
    return outside(place_of(kCrop));
  }
  for (std::size_t i = 0; i < parts.pixels.size(); ++i) {
    if (parts.pixels[i].column >= parts.width || parts.pixels[i].row >= parts.height) {
      return outside(place_of(kPixelList).index(i));
    }
  }
  return true;
}

bool GeneratorReader::check_combination(const Parts& parts) {
  for (const Alternatives& each : kAlternatives) {
    if (std::popcount(parts.seen & each.keys) > 1)
      return reader_.invalid("KEYS_MIXED", std::string(each.message), root());
  }
  const auto has = [&](Key key) { return (parts.seen & bits({key})) != 0; };
  if (has(kExtrinsic) && (parts.seen & kPoseBits) != 0) {
    return reader_.invalid("KEYS_MIXED", "the pose is an \"extrinsic\", or stands in other keys",
                           place_of(kExtrinsic));
  }
  if (parts.kind != kLidar) return check_parts_of_image(parts);
  if (!has(kElevations) && !has(kFirings)) {
    return reader_.invalid("KEY_MISSING", about_key(kLidar, "needs", kElevations), root());
  }
  if (has(kDivergence) != has(kSamples)) {
    return reader_.invalid("KEY_MISSING", "\"divergence\" and \"samples\" need each other", root());
  }
  if (has(kSeed) && !has(kNoise) && !has(kDropout)) {
    return reader_.invalid("KEY_MISSING", "a lidar needs \"noise\" or \"dropout\" for a \"seed\"",
                           root());
  }
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
  return finish_pose(parts.seen, root(), parts.pose) && check_combination(parts) &&
         assemble(parts, generator);
}

bool GeneratorReader::assemble(Parts& parts, RayGenerator& generator) {
  generator.range = parts.range;
  generator.returns = parts.returns;
  const auto has = [&](Key key) { return (parts.seen & bits({key})) != 0; };
  if (has(kCrop)) generator.crop = parts.crop;
  if (has(kPixelList)) generator.pixels = std::move(parts.pixels);
  switch (parts.kind) {
    case kPinhole: {
      Pinhole camera{parts.pose, parts.fov_y, parts.width, parts.height};
      if (has(kFovX)) camera.fov_x = parts.fov_x;
      if (has(kIntrinsics)) camera.intrinsics = parts.intrinsics;
      generator.kind = camera;
      break;
    }
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
      generator.kind = Lidar{std::move(parts.poses),
                             std::move(parts.lasers),
                             parts.azimuths,
                             parts.from,
                             parts.to,
                             parts.divergence,
                             parts.samples};
      generator.noise = {parts.noise, parts.dropout, parts.seed};
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
