#include "tests/bench/embree_scene.h"

#include <algorithm>
#include <vector>

namespace sightline::bench {

namespace {

RTCGeometry triangles(RTCDevice device, const Mesh& mesh, const Affine& place) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                             RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                             mesh.positions.size()));
  const bool identity = place.is_identity();
  for (const Vec3f& p : mesh.positions) {
    const Vec3d world = place.apply(p);
    *vertex++ = identity ? p.x : static_cast<float>(world.x);
    *vertex++ = identity ? p.y : static_cast<float>(world.y);
    *vertex++ = identity ? p.z : static_cast<float>(world.z);
  }
  auto* index = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), mesh.indices.size() / 3));
  std::copy(mesh.indices.begin(), mesh.indices.end(), index);
  rtcCommitGeometry(geometry);
  return geometry;
}

RTCScene new_scene(RTCDevice device, const EmbreeOptions& options) {
  const RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, options.flags);
  rtcSetSceneBuildQuality(scene, options.quality);
  return scene;
}

}  // namespace

EmbreeScene::EmbreeScene(const Scene& scene, const EmbreeOptions& options)
    : device_(rtcNewDevice(options.device)), top_(new_scene(device_, options)) {
  const SceneDescription& description = scene.description();
  std::vector<std::uint32_t> uses(description.meshes.size(), 0);
  for (const Instance& instance : description.instances) ++uses[instance.mesh];

  std::vector<RTCScene> unique(description.meshes.size(), nullptr);
  for (std::uint32_t i = 0; i < description.instances.size(); ++i) {
    const Instance& instance = description.instances[i];
    const Mesh& mesh = *description.meshes[instance.mesh];
    if (uses[instance.mesh] == 1) {
      const RTCGeometry geometry = triangles(device_, mesh, instance.world_from_mesh);
      rtcAttachGeometryByID(top_, geometry, i);
      rtcReleaseGeometry(geometry);
      continue;
    }
    has_instances_ = true;
    RTCScene& below = unique[instance.mesh];
    if (below == nullptr) {
      below = new_scene(device_, options);
      const RTCGeometry geometry = triangles(device_, mesh, {});
      rtcAttachGeometryByID(below, geometry, 0);
      rtcReleaseGeometry(geometry);
      rtcCommitScene(below);
    }
    const RTCGeometry placed = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(placed, below);
    float matrix[12];
    for (int row = 0; row < 3; ++row) {
      for (int k = 0; k < 4; ++k) {
        matrix[row * 4 + k] = static_cast<float>(instance.world_from_mesh.m[row][k]);
      }
    }
    rtcSetGeometryTransform(placed, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrix);
    rtcCommitGeometry(placed);
    rtcAttachGeometryByID(top_, placed, i);
    rtcReleaseGeometry(placed);
  }
  rtcCommitScene(top_);
  for (RTCScene below : unique) {
    if (below != nullptr) rtcReleaseScene(below);  // its instances hold it
  }
}

EmbreeScene::~EmbreeScene() {
  rtcReleaseScene(top_);
  rtcReleaseDevice(device_);
}

}  // namespace sightline::bench
