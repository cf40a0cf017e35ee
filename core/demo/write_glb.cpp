#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>

#include "core/demo/demo.h"

// Written by hand rather than through a JSON library, so that the bytes depend on this file alone.

namespace sightline::demo {

namespace {

constexpr std::uint32_t kComponentU16 = 5123, kComponentU32 = 5125, kComponentF32 = 5126;
constexpr std::uint32_t kTargetVertices = 34962, kTargetIndices = 34963;

/// The shortest decimal that reads back as the same float64.
std::string number(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

std::string quoted(const std::string& text) {
  static constexpr char kHex[] = "0123456789abcdef";
  std::string out = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += "\\u00";
      out += kHex[static_cast<unsigned char>(c) >> 4];
      out += kHex[static_cast<unsigned char>(c) & 15];
    } else {
      out += c;
    }
  }
  return out + '"';
}

/// `name` and its elements, or nothing: glTF forbids empty arrays.
void append_array(std::string& json, const char* name, const std::vector<std::string>& elements) {
  if (elements.empty()) return;
  json += ",\"";
  json += name;
  json += "\":[";
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (i > 0) json += ',';
    json += elements[i];
  }
  json += ']';
}

void append_u32(std::vector<std::byte>& bytes, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8)
    bytes.push_back(static_cast<std::byte>(value >> shift));
}

void append_u16(std::vector<std::byte>& bytes, std::uint32_t value) {
  for (int shift = 0; shift < 16; shift += 8)
    bytes.push_back(static_cast<std::byte>(value >> shift));
}

void append_f32(std::vector<std::byte>& bytes, float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  append_u32(bytes, bits);
}

/// The glTF arrays that grow with each mesh.
struct Sections {
  std::vector<std::string> accessors, views, meshes, materials;
  std::vector<std::byte> binary;

  std::string add_view(std::size_t begin, std::uint32_t target) {
    views.push_back("{\"buffer\":0,\"byteOffset\":" + std::to_string(begin) +
                    ",\"byteLength\":" + std::to_string(binary.size() - begin) +
                    ",\"target\":" + std::to_string(target) + "}");
    return std::to_string(views.size() - 1);
  }
  std::string add_accessor(const std::string& view, std::uint32_t component, std::size_t count,
                           const std::string& rest) {
    accessors.push_back("{\"bufferView\":" + view +
                        ",\"componentType\":" + std::to_string(component) +
                        ",\"count\":" + std::to_string(count) + rest + "}");
    return std::to_string(accessors.size() - 1);
  }
};

std::string add_positions(Sections& out, const DemoMesh& mesh) {
  const std::size_t begin = out.binary.size();
  float low[3], high[3];
  std::fill(low, low + 3, std::numeric_limits<float>::infinity());
  std::fill(high, high + 3, -std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    append_f32(out.binary, mesh.positions[i]);
    low[i % 3] = std::min(low[i % 3], mesh.positions[i]);
    high[i % 3] = std::max(high[i % 3], mesh.positions[i]);
  }
  const auto triple = [](const float* v) {
    return "[" + number(static_cast<double>(v[0])) + "," + number(static_cast<double>(v[1])) + "," +
           number(static_cast<double>(v[2])) + "]";
  };
  return out.add_accessor(out.add_view(begin, kTargetVertices), kComponentF32,
                          mesh.positions.size() / 3,
                          ",\"type\":\"VEC3\",\"min\":" + triple(low) + ",\"max\":" + triple(high));
}

/// `name` as a member behind others, or nothing where there is none.
std::string add_attribute(Sections& out, const char* name, const std::vector<float>& values,
                          std::size_t width) {
  if (values.empty()) return "";
  const std::size_t begin = out.binary.size();
  for (const float value : values) append_f32(out.binary, value);
  const std::string accessor =
      out.add_accessor(out.add_view(begin, kTargetVertices), kComponentF32, values.size() / width,
                       ",\"type\":\"VEC" + std::to_string(width) + "\"");
  return ",\"" + std::string(name) + "\":" + accessor;
}

std::string add_indices(Sections& out, const DemoMesh& mesh) {
  const std::size_t begin = out.binary.size();
  // 65535 is the primitive restart value, which glTF does not allow as an index.
  const bool narrow = mesh.positions.size() / 3 <= 65535;
  for (std::uint32_t index : mesh.indices) {
    narrow ? append_u16(out.binary, index) : append_u32(out.binary, index);
  }
  const std::string view = out.add_view(begin, kTargetIndices);
  while (out.binary.size() % 4 != 0) out.binary.push_back(std::byte{0});
  return out.add_accessor(view, narrow ? kComponentU16 : kComponentU32, mesh.indices.size(),
                          ",\"type\":\"SCALAR\"");
}

void add_mesh(Sections& out, const DemoMesh& mesh) {
  const std::string material = "{\"name\":" + quoted(mesh.material) + "}";
  const auto known = std::find(out.materials.begin(), out.materials.end(), material);
  const auto index = known - out.materials.begin();
  if (known == out.materials.end()) out.materials.push_back(material);
  const std::string positions = add_positions(out, mesh), indices = add_indices(out, mesh);
  const std::string attributes = add_attribute(out, "NORMAL", mesh.normals, 3) +
                                 add_attribute(out, "TEXCOORD_0", mesh.uvs, 2) +
                                 add_attribute(out, "COLOR_0", mesh.colours, 4);
  out.meshes.push_back("{\"name\":" + quoted(mesh.name) +
                       ",\"primitives\":[{\"attributes\":{\"POSITION\":" + positions + attributes +
                       "},\"indices\":" + indices + ",\"material\":" + std::to_string(index) +
                       "}]}");
}

/// Column-major, as glTF stores it; empty for the identity.
std::string matrix_member(const Affine& matrix) {
  if (matrix.is_identity()) return "";
  std::string out = ",\"matrix\":[";
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) out += number(matrix.m[row][column]) + ",";
    out += column == 3 ? "1]" : "0,";
  }
  return out;
}

}  // namespace

std::vector<std::byte> write_glb(const DemoScene& scene) {
  Sections out;
  for (const DemoMesh& mesh : scene.meshes) add_mesh(out, mesh);

  std::vector<std::string> roots, nodes;
  std::vector<std::vector<std::string>> children(scene.nodes.size());
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const int parent = scene.nodes[i].parent;
    (parent < 0 ? roots : children[static_cast<std::size_t>(parent)]).push_back(std::to_string(i));
  }
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const DemoNode& node = scene.nodes[i];
    std::string json = "{\"name\":" + quoted(node.name) + matrix_member(node.parent_from_node);
    if (node.mesh >= 0) json += ",\"mesh\":" + std::to_string(node.mesh);
    append_array(json, "children", children[i]);
    nodes.push_back(json + "}");
  }
  std::string root_scene = "{\"name\":" + quoted(scene.name);
  append_array(root_scene, "nodes", roots);
  root_scene += '}';

  std::string json = R"({"asset":{"version":"2.0","generator":"Sightline"},"scene":0)";
  append_array(json, "scenes", {root_scene});
  append_array(json, "nodes", nodes);
  append_array(json, "meshes", out.meshes);
  append_array(json, "materials", out.materials);
  append_array(json, "accessors", out.accessors);
  append_array(json, "bufferViews", out.views);
  if (!out.binary.empty()) {
    append_array(json, "buffers", {"{\"byteLength\":" + std::to_string(out.binary.size()) + "}"});
  }
  json += '}';
  while (json.size() % 4 != 0) json += ' ';

  // Header, JSON chunk, BIN chunk (glTF 2.0, "GLB File Format").
  std::vector<std::byte> glb;
  const std::size_t total = 20 + json.size() + (out.binary.empty() ? 0 : 8 + out.binary.size());
  glb.reserve(total);
  append_u32(glb, 0x46546c67);
  append_u32(glb, 2);
  append_u32(glb, static_cast<std::uint32_t>(total));
  append_u32(glb, static_cast<std::uint32_t>(json.size()));
  append_u32(glb, 0x4e4f534a);
  for (char c : json) glb.push_back(static_cast<std::byte>(c));
  if (!out.binary.empty()) {
    append_u32(glb, static_cast<std::uint32_t>(out.binary.size()));
    append_u32(glb, 0x004e4942);
    glb.insert(glb.end(), out.binary.begin(), out.binary.end());
  }
  return glb;
}

}  // namespace sightline::demo
