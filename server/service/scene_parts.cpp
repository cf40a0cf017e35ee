#include "server/service/scene_parts.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "proto/json/json_parts.h"
#include "proto/json/json_pointer.h"

namespace sightline {
namespace {

void write_id(JsonWriter& out, std::uint32_t id) {
  if (id == kNone) return out.raw("null");
  out.number(id);
}

/// Three numbers with points between them. False if that is not what it is.
bool parse_id(std::string_view text, std::array<std::uint32_t, 3>& id) {
  const char* at = text.data();
  const char* end = at + text.size();
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [last, error] = std::from_chars(at, end, id[k]);
    if (error != std::errc()) return false;
    at = last;
    if (k < 2 && (at == end || *at++ != '.')) return false;
  }
  return at == end;
}

/// The primitive that the file calls so; null if the scene has none or not that triangle.
const Primitive* find_triangle(const SceneDescription& scene,
                               const std::array<std::uint32_t, 3>& id) {
  if (id[0] >= scene.instances.size()) return nullptr;
  for (const Primitive& part : scene.meshes[scene.instances[id[0]].mesh]->primitives) {
    if (part.file_primitive == id[1]) return id[2] < part.triangle_count ? &part : nullptr;
  }
  return nullptr;
}

void write_triangle(JsonWriter& out, const Scene& scene, const std::array<std::uint32_t, 3>& id,
                    const Primitive& part) {
  const SceneDescription& description = scene.description();
  const WorldTriangle corners = scene.world_triangle({id[0], part.first_triangle + id[2]});
  write(out, "{\"instance\":", id[0], ",\"primitive\":", id[1], ",\"triangle\":", id[2],
        ",\"corners\":[", corners.v0, ',', corners.v1, ',', corners.v2,
        "],\"node_id\":", description.nodes[description.instances[id[0]].node].file_node,
        ",\"material_id\":");
  write_id(out, part.material);
  out.raw('}');
}

}  // namespace

Result<std::string> encode_triangles(const Scene& scene, std::string_view ids) {
  JsonWriter out(1024);
  out.raw("{\"triangles\":[");
  for (std::size_t count = 0; !ids.empty(); ++count) {
    if (count == kMostTriangles) {
      return Error{ErrorKind::kTooLarge, "TOO_MANY_TRIANGLES",
                   "a request may name " + std::to_string(kMostTriangles) + " triangles", ""};
    }
    const std::string_view text = ids.substr(0, ids.find(','));
    ids.remove_prefix(std::min(text.size() + 1, ids.size()));
    std::array<std::uint32_t, 3> id{};
    const Primitive* part = parse_id(text, id) ? find_triangle(scene.description(), id) : nullptr;
    if (part == nullptr) {
      return Error{ErrorKind::kInvalid, "TRIANGLE_UNKNOWN",
                   "\"" + std::string(cut_utf8(text, 64)) +
                       "\" is no instance.primitive.triangle of this scene",
                   ""};
    }
    if (count > 0) out.raw(',');
    write_triangle(out, scene, id, *part);
  }
  out.raw("]}\n");
  return out.take();
}

std::string encode_self_check(const SelfCheck& check) {
  JsonWriter out(256);
  write(out, "{\"rays\":", check.rays, ",\"hits\":", check.hits,
        ",\"triangles_decided\":", check.triangles, ",\"different\":[");
  for (std::size_t i = 0; i < check.different.size(); ++i) {
    if (i > 0) out.raw(',');
    out.number(check.different[i]);
  }
  out.raw("]}\n");
  return out.take();
}

}  // namespace sightline
