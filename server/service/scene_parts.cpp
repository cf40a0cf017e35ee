#include "server/service/scene_parts.h"

#include <algorithm>
#include <charconv>

#include "proto/json/json_parts.h"
#include "proto/json/json_pointer.h"

namespace sightline {
namespace {

/// Three numbers with points between them. False if that is not what it is.
bool parse_name(std::string_view text, TriangleName& name) {
  const char* at = text.data();
  const char* end = at + text.size();
  for (std::uint32_t* number : {&name.instance, &name.primitive, &name.triangle}) {
    const auto [last, error] = std::from_chars(at, end, *number);
    if (error != std::errc()) return false;
    at = last;
    if (number != &name.triangle && (at == end || *at++ != '.')) return false;
  }
  return at == end;
}

void write_triangle(JsonWriter& out, const Scene& scene, const TriangleName& name, TriangleId id) {
  const SceneDescription& description = scene.description();
  const Instance& instance = description.instances[id.instance];
  const WorldTriangle corners = scene.world_triangle(id);
  write(out, "{\"instance\":", name.instance, ",\"primitive\":", name.primitive,
        ",\"triangle\":", name.triangle, ",\"corners\":[", corners.v0, ',', corners.v1, ',',
        corners.v2, "],\"node_id\":", description.nodes[instance.node].file_node,
        ",\"material_id\":");
  write_id(out, description.meshes[instance.mesh]->primitives[scene.primitive_of(id)].material);
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
    TriangleName name;
    const auto id = parse_name(text, name) ? scene.find_triangle(name) : std::nullopt;
    if (!id) {
      return Error{ErrorKind::kInvalid, "TRIANGLE_UNKNOWN",
                   "\"" + std::string(cut_utf8(text, 64)) +
                       "\" is no instance.primitive.triangle of this scene",
                   ""};
    }
    if (count > 0) out.raw(',');
    write_triangle(out, scene, name, *id);
  }
  out.raw("]}\n");
  return out.take();
}

std::string encode_animations(const std::vector<AnimationSummary>& animations) {
  JsonWriter out(64 + animations.size() * 128);
  write(out, "{\"total\":", std::uint64_t{animations.size()}, ",\"animations\":[");
  for (std::size_t i = 0; i < animations.size(); ++i) {
    const AnimationSummary& each = animations[i];
    write(out, i > 0 ? ",{\"index\":" : "{\"index\":", std::uint64_t{i}, ",\"name\":");
    out.name(each.name);
    out.raw(",\"duration\":");
    if (each.problem.empty()) {
      out.number(each.duration);
    } else {
      out.raw("null,\"problem\":");
      out.string(each.problem);
    }
    out.raw(",\"nodes\":[");
    for (std::size_t k = 0; k < each.nodes.size(); ++k) {
      write(out, k > 0 ? "," : "", each.nodes[k]);
    }
    out.raw("]}");
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
