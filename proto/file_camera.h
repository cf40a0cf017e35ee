#pragma once
/// FileCamera: a reference to a camera of a scene's file, in a client's request.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/query/ray_generators.h"

namespace sightline {

/// A camera of the scene's glTF file, chosen by name or index, and the size of the wanted image in
/// pixels.
struct FileCamera {
  std::string name;  ///< name of the camera, or of a node that has it; empty if `index` is set
  std::optional<std::uint32_t> index;  ///< index in the file's "cameras"
  std::uint64_t width = 0, height = 0;
};
/// A function that returns a generator of the rays of the camera's pixels. Errors: CAMERA_UNKNOWN.
using FindCamera = std::function<Result<RayGenerator>(const FileCamera& camera)>;

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
