#pragma once
/// Cameras of a scene's file as makers of rays.

#include "core/scene/scene.h"
#include "proto/file_camera.h"

namespace sightline {

/// The first camera in the order of nodes that has this index, or else this name, or else stands at
/// a node of this name. It stands where its node is now, its scale left out [glTF2] 3.10; the
/// height of the image is what the file says, its width by the pixels; limits are those of the
/// file. Errors: CAMERA_UNKNOWN.
Result<RayGenerator> camera_rays(const Scene& scene, const FileCamera& asked);

}  // namespace sightline
