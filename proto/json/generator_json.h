#pragma once
/// GeneratorReader: reads the "generator" of a JSON body, which describes rays to be made. For
/// files of this room that use simdjson.
///
///   {"kind":"pinhole","position":[0,2,9],"look_at":[0,1,0],"fov_y":60,"width":640,"height":480}
///
/// "range":[tmin,tmax] may be in all kinds; a null tmax means no limit. Other keys, with defaults:
/// pinhole           pose, fov_y (60), fov_x or intrinsics [fx,fy,cx,cy], width, height, part
/// orthographic      pose, extent_y, width, height, part
/// equirectangular   pose, width, height, part
/// lidar             pose or "poses":[{pose}], elevations or firings [[azimuth,elevation]],
///                   azimuths, sector [from,to], returns (1), divergence and samples, noise,
///                   dropout, seed
/// camera            camera (name or index in the file), width, height, part
/// hemisphere        points, normals, count, seed (0), distribution: "cosine" or "uniform"
/// A pose is "position", "forward" (or "look_at") and "up", with the defaults 0, (0,0,-1) and
/// (0,1,0); of a camera also "extrinsic":[[4 numbers] x 4]. A part is "crop":[left,top,width,height]
/// or "pixels":[[column,row]].

#include <cstdint>
#include <functional>
#include <span>
#include <utility>

#include "core/query/ray_generators.h"
#include "proto/file_camera.h"
#include "proto/json/json_reader.h"

namespace sightline {

/// Called before `count` rays are made or poses are stored; its error becomes the answer.
using AdmitMade = std::function<Status(std::uint64_t count)>;

/// Reads one generator; makes no rays. The reader and `find_camera` must outlive the object.
class GeneratorReader {
 public:
  /// Reads the member "generator".
  /// reader       gets the errors
  /// most         the most rays that the generator may make, and the most entries of its lists
  /// find_camera  null if there is no scene
  /// admit        null: every number is admitted
  GeneratorReader(JsonReader& reader, std::uint64_t most, const FindCamera& find_camera,
                  const AdmitMade& admit)
      : reader_(reader), most_(most), find_camera_(find_camera), admit_(admit) {}
  /// Reads a camera at `place` without making rays. Only kinds with an image, and only their keys,
  /// are accepted.
  GeneratorReader(JsonReader& reader, const FindCamera& find_camera, JsonPointer place)
      : reader_(reader),
        most_(kMostPixels),
        find_camera_(find_camera),
        place_(std::move(place)),
        is_view_(true) {}

  /// Reads the generator. Returns false if the reader has an error: those of its functions, 422
  /// KEY_MISSING, KEY_UNKNOWN (not in this kind), CAMERA_UNKNOWN, 413 RAYS_TOO_MANY, those of
  /// `admit`. `generator` is then unspecified.
  bool read(JsonReader::Value value, RayGenerator& generator);

 private:
  static constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 53;
  struct Parts;
  JsonPointer root() const { return JsonPointer(place_); }
  JsonPointer place_of(std::size_t key) const;
  bool read_part(std::size_t which, JsonReader::Value value, Parts& parts);
  bool read_pose(JsonReader::Value value, const JsonPointer& place, Pose& pose);
  bool read_pose_part(std::size_t which, JsonReader::Value value, const JsonPointer& place,
                      Pose& pose);
  bool read_numbers(JsonReader::Value value, const JsonPointer& place, std::size_t count,
                    double* out);
  bool read_range(JsonReader::Value value, const JsonPointer& place, RayRange& range);
  bool finish_pose(unsigned seen, const JsonPointer& place, Pose& pose);
  bool assemble(Parts& parts, RayGenerator& generator);
  bool admit(std::uint64_t count, const JsonPointer& place);
  bool read_camera(JsonReader::Value value, const JsonPointer& place, FileCamera& camera);
  bool read_intrinsics(JsonReader::Value value, const JsonPointer& place, Intrinsics& lens);
  bool read_extrinsic(JsonReader::Value value, const JsonPointer& place, Pose& pose);
  bool read_counts(JsonReader::Value value, const JsonPointer& place,
                   std::span<std::uint64_t* const> out);
  bool read_crop(JsonReader::Value value, const JsonPointer& place, Crop& crop);
  bool read_pixel(JsonReader::Value value, const JsonPointer& place, Pixel& pixel);
  bool check_combination(const Parts& parts);
  bool check_parts_of_image(const Parts& parts);
  bool too_many(const JsonPointer& place);

  JsonReader& reader_;
  std::uint64_t most_;
  const FindCamera& find_camera_;
  const AdmitMade admit_ = {};
  const JsonPointer place_ = JsonPointer().key("generator");
  const bool is_view_ = false;
};

}  // namespace sightline

// Tests: tests/unit/proto/ray_json_test.cpp
