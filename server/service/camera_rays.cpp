#include "server/service/camera_rays.h"

#include <algorithm>
#include <numbers>

#include "proto/json/json_pointer.h"

namespace sightline {

Result<RayGenerator> camera_rays(const Scene& scene, const FileCamera& asked) {
  const SceneDescription& description = scene.description();
  const auto& cameras = description.cameras;
  const auto find = [&](const auto& fits) {
    return std::find_if(cameras.begin(), cameras.end(), fits);
  };
  auto camera = find([&](const Camera& each) {
    return asked.index ? each.file_camera == *asked.index : each.name == asked.name;
  });
  if (camera == cameras.end() && !asked.index) {
    camera =
        find([&](const Camera& each) { return description.nodes[each.node].name == asked.name; });
  }
  if (camera == cameras.end()) {
    const std::string name = asked.index ? std::to_string(*asked.index)
                                         : '"' + std::string(cut_utf8(asked.name, 64)) + '"';
    return Error{ErrorKind::kInvalid, "CAMERA_UNKNOWN",
                 "of the " + std::to_string(cameras.size()) +
                     " cameras that the scene shows none is " + name,
                 ""};
  }
  const auto& m = description.nodes[camera->node].world_from_node.m;
  Pose pose;
  pose.position = {m[0][3], m[1][3], m[2][3]};
  pose.forward = {-m[0][2], -m[1][2], -m[2][2]};
  pose.up = {m[0][1], m[1][1], m[2][1]};
  RayGenerator generator;
  generator.range = {camera->near, camera->far};
  if (camera->orthographic) {
    generator.kind = Orthographic{pose, 2 * camera->size_y, asked.width, asked.height};
  } else {
    const double degrees = camera->size_y * 180 / std::numbers::pi;
    generator.kind = Pinhole{pose, degrees, asked.width, asked.height};
  }
  return generator;
}

}  // namespace sightline
