#include "tests/bench/embree_build.h"

#include <sys/types.h>

#include <string>

namespace sightline::bench {

namespace {

bool count_memory(void* held, ssize_t bytes, bool) {
  *static_cast<std::atomic<long>*>(held) += bytes;
  return true;
}

}  // namespace

EmbreeBuild::EmbreeBuild(const SceneDescription& description, int threads, RTCBuildQuality quality)
    : device_(rtcNewDevice(threads == 1 ? "threads=1" : "")),
      quality_(quality),
      description_(description) {
  rtcSetDeviceMemoryMonitorFunction(device_, count_memory, &held_);
  for (const auto& mesh : description.meshes) {
    std::vector<float>& to = vertices_.emplace_back();
    to.reserve(mesh->positions.size() * 3 + 1);
    for (const Vec3f& p : mesh->positions) to.insert(to.end(), {p.x, p.y, p.z});
    to.push_back(0);
    indices_.emplace_back(mesh->indices.begin(), mesh->indices.end());
  }
}

EmbreeBuild::~EmbreeBuild() {
  drop();
  rtcReleaseDevice(device_);
}

void EmbreeBuild::drop() {
  if (scene_ != nullptr) rtcReleaseScene(scene_);
  scene_ = nullptr;
}

double EmbreeBuild::build() {
  drop();
  const long before = held_;
  scene_ = rtcNewScene(device_);
  rtcSetSceneBuildQuality(scene_, quality_);
  for (std::size_t i = 0; i < description_.meshes.size(); ++i) {
    const Mesh& mesh = *description_.meshes[i];
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryBuildQuality(geometry, quality_);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               vertices_[i].data(), 0, 3 * sizeof(float), mesh.positions.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               indices_[i].data(), 0, 3 * sizeof(std::uint32_t),
                               mesh.indices.size() / 3);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene_);
  return static_cast<double>(held_ - before);
}

}  // namespace sightline::bench
