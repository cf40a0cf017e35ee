#include "core/scene/surface_reader.h"

#include <cmath>
#include <limits>

namespace sightline {

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

}  // namespace

void SurfaceReader::go_to(TriangleId id, const HitDetail& detail) {
  const SceneDescription& description = scene_.description();
  const Mesh& mesh = *description.meshes[description.instances[id.instance].mesh];
  const std::uint32_t number = mesh.attributes.empty() ? 0 : scene_.primitive_of(id);
  attributes_ = number < mesh.attributes.size() ? &mesh.attributes[number] : nullptr;
  corners_ = mesh.indices.corners(id.triangle);
  weight_[0] = (1 - detail.u) - detail.v;
  weight_[1] = detail.u;
  weight_[2] = detail.v;
  if (instance_ != id.instance) normals_.reset();
  instance_ = id.instance;
}

Vec3d SurfaceReader::shading_normal() {
  double n[4];
  if (!interpolate(VertexAttribute::kNormal, n)) return {kUnknown, kUnknown, kUnknown};
  if (!normals_) normals_.emplace(scene_.description().instances[instance_].world_from_mesh);
  return normals_->apply({n[0], n[1], n[2]});
}

std::array<double, 2> SurfaceReader::uv() {
  double n[4];
  if (!interpolate(VertexAttribute::kUv, n)) return {kUnknown, kUnknown};
  return {n[0], n[1]};
}

std::array<double, 4> SurfaceReader::colour() {
  double n[4];
  if (!interpolate(VertexAttribute::kColour, n)) return {kUnknown, kUnknown, kUnknown, kUnknown};
  return {n[0], n[1], n[2], n[3]};
}

bool SurfaceReader::interpolate(VertexAttribute attribute, double (&out)[4]) {
  const VertexNumbers* const numbers =
      attributes_ != nullptr ? attributes_->of(attribute) : nullptr;
  if (numbers == nullptr) return false;
  double at[3][4];
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t vertex = corners_[k] + attributes_->first_vertex;
    if (!numbers->load(vertex, at[k], touched_)) return false;
  }
  for (std::uint32_t c = 0; c < numbers->components(); ++c) {
    out[c] = (weight_[0] * at[0][c] + weight_[1] * at[1][c]) + weight_[2] * at[2][c];
    if (!std::isfinite(out[c])) return false;
  }
  if (numbers->components() == 3) out[3] = 1;
  return true;
}

}  // namespace sightline
