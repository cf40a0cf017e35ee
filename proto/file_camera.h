#pragma once
/// A camera of a scene's file, as a client names it.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/query/ray_generators.h"

namespace sightline {

struct FileCamera {
  std::string name;                    ///< of the camera, or of a node that shows it
  std::optional<std::uint32_t> index;  ///< in the file's "cameras"; then there is no name
  std::uint64_t width = 0, height = 0;
};
/// The rays of its pixels. Errors: CAMERA_UNKNOWN.
using FindCamera = std::function<Result<RayGenerator>(const FileCamera& camera)>;

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
