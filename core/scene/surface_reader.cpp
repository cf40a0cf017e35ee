#include "core/scene/surface_reader.h"

#include <algorithm>
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
  return normals().apply({n[0], n[1], n[2]});
}

const NormalMap& SurfaceReader::normals() {
  if (!normals_) normals_.emplace(scene_.description().instances[instance_].world_from_mesh);
  return *normals_;
}

std::array<double, 4> SurfaceReader::tangent() {
  double n[4];
  constexpr std::array<double, 4> kNone4{kUnknown, kUnknown, kUnknown, kUnknown};
  if (!interpolate(VertexAttribute::kTangent, n) || n[3] == 0) return kNone4;
  const auto& m = scene_.description().instances[instance_].world_from_mesh.m;
  Vec3d direction;
  for (int i = 0; i < 3; ++i) {
    direction[i] = (m[i][0] * n[0] + m[i][1] * n[1]) + m[i][2] * n[2];
  }
  const Vec3d t = unit_or_nan(direction);
  if (std::isnan(t.x)) return kNone4;
  return {t.x, t.y, t.z, (n[3] < 0) != normals().is_mirror() ? -1.0 : 1.0};
}

std::array<double, 2> SurfaceReader::uv() { return pair(VertexAttribute::kUv); }
std::array<double, 2> SurfaceReader::uv1() { return pair(VertexAttribute::kUv1); }

std::array<double, 2> SurfaceReader::pair(VertexAttribute attribute) {
  double n[4];
  if (!interpolate(attribute, n)) return {kUnknown, kUnknown};
  return {n[0], n[1]};
}

std::array<double, 4> SurfaceReader::colour() {
  double n[4];
  if (!interpolate(VertexAttribute::kColour, n)) return {kUnknown, kUnknown, kUnknown, kUnknown};
  return {n[0], n[1], n[2], n[3]};
}

void SurfaceReader::named(VertexAttribute attribute, std::span<double> out) {
  double n[4];
  if (interpolate(attribute, n)) {
    std::copy_n(n, out.size(), out.begin());
  } else {
    std::fill(out.begin(), out.end(), kUnknown);
  }
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
