#pragma once
/// Makes ray generators of the cameras in a scene's file.

#include "core/scene/scene.h"
#include "proto/file_camera.h"

namespace sightline {

/// Returns a generator for the first camera, in the order of nodes, that has the index, or the
/// name, or belongs to a node of the name. It is placed by its node's present matrix without scale
/// [glTF2] 3.10. The field of view is the file's in height; its width follows from the pixels.
/// The limits of the rays are znear and zfar of the file. Errors: CAMERA_UNKNOWN.
Result<RayGenerator> camera_rays(const Scene& scene, const FileCamera& asked);

}  // namespace sightline

// Tests: tests/integration/images_test.py
