#include "proto/binary/geometry_binary.h"

#include <algorithm>
#include <bit>

#include "proto/binary/binary_answer.h"

namespace sightline {
namespace {

constexpr std::size_t kLinear = 9;

void announce(BinaryAnswer& out, const GeometryAnswer& answer, std::size_t positions,
              std::size_t triangles) {
  const std::size_t meshes = answer.meshes.size(), parts = answer.parts.size(),
                    placements = answer.placements.size();
  out.announce<std::uint64_t>("all_meshes", 1);
  out.announce<std::uint64_t>("all_bytes", 1);
  out.announce<std::uint64_t>("next", answer.next ? 1 : 0);
  out.announce<std::uint32_t>("mesh_id", meshes);
  out.announce<double>("origin", meshes, 3);
  out.announce<std::uint64_t>("first_position", meshes + 1);
  out.announce<std::uint64_t>("first_triangle", meshes + 1);
  out.announce<float>("positions", positions, 3);
  out.announce<std::uint32_t>("indices", triangles, 3);
  out.announce<std::uint32_t>("part_mesh", parts);
  out.announce<std::uint32_t>("part_first", parts);
  out.announce<std::uint32_t>("part_triangles", parts);
  out.announce<std::uint32_t>("primitive", parts);
  out.announce<std::uint32_t>("material_id", parts);
  out.announce<double>("colour", parts, 4);
  out.announce<std::uint32_t>("placed_mesh", placements);
  out.announce<std::uint32_t>("instance", placements);
  out.announce<std::uint32_t>("node_id", placements);
  // A column of no numbers has rows of one, for readers that divide by the width.
  const auto width = static_cast<std::uint32_t>(std::max<std::size_t>(placements, 1));
  out.announce<std::uint8_t>("linear", placements > 0 ? kLinear * sizeof(float) : 0, width);
  out.announce<double>("at", placements, 3);
}

/// What all meshes have, one after the other: mesh and number of row `row` of a column of theirs.
/// Rows are asked for in their order.
class MeshRows {
 public:
  MeshRows(const std::vector<GeometryMesh>& meshes, std::span<const std::uint64_t> first)
      : meshes_(meshes), first_(first) {}
  const GeometryMesh& mesh(std::size_t row) {
    while (row >= first_[at_ + 1]) ++at_;
    return meshes_[at_];
  }
  std::size_t number(std::size_t row) const { return row - first_[at_]; }

 private:
  const std::vector<GeometryMesh>& meshes_;
  std::span<const std::uint64_t> first_;
  std::size_t at_ = 0;
};

void write_meshes(BinaryAnswer& out, const GeometryAnswer& answer,
                  std::span<const std::uint64_t> first_position,
                  std::span<const std::uint64_t> first_triangle) {
  const auto& meshes = answer.meshes;
  out.next<std::uint32_t>([&](std::size_t i, std::uint32_t) { return meshes[i].file_mesh; });
  out.next<double>(
      [&](std::size_t i, std::uint32_t k) { return meshes[i].origin[static_cast<int>(k)]; });
  out.next(first_position);
  out.next(first_triangle);
  MeshRows points(meshes, first_position);
  out.next<float>([&](std::size_t row, std::uint32_t k) {
    const GeometryMesh& mesh = points.mesh(row);
    const Vec3f& p = mesh.positions[points.number(row)];
    const float component = k == 0 ? p.x : k == 1 ? p.y : p.z;
    return static_cast<double>(component) - mesh.origin[static_cast<int>(k)];
  });
  MeshRows corners(meshes, first_triangle);
  out.next<std::uint32_t>([&](std::size_t row, std::uint32_t k) {
    const GeometryMesh& mesh = corners.mesh(row);
    return mesh.indices[3 * corners.number(row) + k];
  });
}

void write_parts(BinaryAnswer& out, const std::vector<GeometryPart>& parts) {
  const auto column = [&](std::uint32_t GeometryPart::*member) {
    out.next<std::uint32_t>([&](std::size_t i, std::uint32_t) { return parts[i].*member; });
  };
  column(&GeometryPart::mesh);
  column(&GeometryPart::first_triangle);
  column(&GeometryPart::triangles);
  column(&GeometryPart::file_primitive);
  column(&GeometryPart::material);
  out.next<double>([&](std::size_t i, std::uint32_t k) { return parts[i].colour[k]; });
}

void write_placements(BinaryAnswer& out, const std::vector<GeometryPlacement>& placements) {
  const auto column = [&](std::uint32_t GeometryPlacement::*member) {
    out.next<std::uint32_t>([&](std::size_t i, std::uint32_t) { return placements[i].*member; });
  };
  column(&GeometryPlacement::mesh);
  column(&GeometryPlacement::instance);
  column(&GeometryPlacement::file_node);
  // Alike bytes in a row: they are compressed to two thirds of whole numbers.
  out.next<std::uint8_t>([&](std::size_t row, std::uint32_t i) {
    const auto number = static_cast<float>(placements[i].linear[row % kLinear]);
    return std::bit_cast<std::uint32_t>(number) >> (8 * (row / kLinear)) & 0xffu;
  });
  out.next<double>(
      [&](std::size_t i, std::uint32_t k) { return placements[i].at[static_cast<int>(k)]; });
}

}  // namespace

std::string encode_geometry(const GeometryAnswer& answer) {
  std::vector<std::uint64_t> first_position{0}, first_triangle{0};
  for (const GeometryMesh& mesh : answer.meshes) {
    first_position.push_back(first_position.back() + mesh.positions.size());
    first_triangle.push_back(first_triangle.back() + mesh.indices.size() / 3);
  }
  BinaryAnswer out;
  announce(out, answer, first_position.back(), first_triangle.back());
  out.begin();
  const auto one = [&](std::uint64_t number) {
    out.next<std::uint64_t>([&](std::size_t, std::uint32_t) { return number; });
  };
  one(answer.all_meshes);
  one(answer.all_bytes);
  one(answer.next.value_or(0));
  write_meshes(out, answer, first_position, first_triangle);
  write_parts(out, answer.parts);
  write_placements(out, answer.placements);
  return out.take();
}

}  // namespace sightline
