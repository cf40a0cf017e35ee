#include "tests/crosscheck/embree_scene.h"

#include <cmath>
#include <limits>

namespace sightline::crosscheck {
namespace {

/// Embree's own bound of a valid ray: the root of the largest float32.
constexpr float kEmbreeLargest = 1.844e18F;

bool in_range(const Vec3d& v) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::fabs(static_cast<float>(v[axis])) <= kEmbreeLargest)) return false;
  }
  return true;
}

RTCRay rounded(const Ray& ray) {
  RTCRay result{};
  result.org_x = static_cast<float>(ray.origin.x);
  result.org_y = static_cast<float>(ray.origin.y);
  result.org_z = static_cast<float>(ray.origin.z);
  result.dir_x = static_cast<float>(ray.direction.x);
  result.dir_y = static_cast<float>(ray.direction.y);
  result.dir_z = static_cast<float>(ray.direction.z);
  result.tnear = static_cast<float>(ray.tmin);
  result.tfar = static_cast<float>(ray.tmax);
  result.mask = 0xffffffffu;
  return result;
}

#if RTC_VERSION_MAJOR >= 4
void intersect(RTCScene scene, RTCRayHit& query) { rtcIntersect1(scene, &query, nullptr); }
void occluded(RTCScene scene, RTCRay& query) { rtcOccluded1(scene, &query, nullptr); }
#else
void intersect(RTCScene scene, RTCRayHit& query) {
  RTCIntersectContext context{};
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
}
void occluded(RTCScene scene, RTCRay& query) {
  RTCIntersectContext context{};
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &query);
}
#endif

}  // namespace

EmbreeScene::EmbreeScene(std::span<const oracle::Triangle> triangles, bool robust)
    : device_(rtcNewDevice("threads=2")), scene_(rtcNewScene(device_)) {
  if (robust) rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  const std::size_t count = triangles.size();
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3 * count));
  auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), count));
  for (std::size_t i = 0; i < count; ++i) {
    for (const Vec3d& v : {triangles[i].v0, triangles[i].v1, triangles[i].v2}) {
      for (int axis = 0; axis < 3; ++axis) *vertices++ = static_cast<float>(v[axis]);
    }
    for (std::size_t k = 0; k < 3; ++k) *indices++ = static_cast<std::uint32_t>(3 * i + k);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_);
}

EmbreeScene::~EmbreeScene() {
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

bool EmbreeScene::accepts(const Ray& ray) {
  return in_range(ray.origin) && in_range(ray.direction) && ray.tmin >= 0 &&
         std::isfinite(static_cast<float>(ray.tmin));
}

std::optional<EmbreeHit> EmbreeScene::closest(const Ray& ray) const {
  RTCRayHit query{};
  query.ray = rounded(ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.primID = RTC_INVALID_GEOMETRY_ID;
  intersect(scene_, query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return EmbreeHit{query.hit.primID, query.ray.tfar};
}

bool EmbreeScene::any(const Ray& ray) const {
  RTCRay query = rounded(ray);
  occluded(scene_, query);
  return query.tfar < 0;
}

}  // namespace sightline::crosscheck
