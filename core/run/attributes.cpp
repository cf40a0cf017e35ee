/// What the file says of the vertices of hits. Read for those hits alone, where it lies.

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/run/engine_state.h"
#include "core/scene/surface_reader.h"

namespace sightline {

namespace {

/// Makes the columns of the names, without values, and finds the attributes in the scene. Of a name
/// that it does not have there is none.
std::vector<std::optional<VertexAttribute>> make_columns(const SceneDescription& scene,
                                                         std::span<const std::string> names,
                                                         std::size_t count,
                                                         std::vector<NamedColumn>& columns) {
  std::vector<std::optional<VertexAttribute>> found;
  columns.clear();
  for (const std::string& name : names) {
    found.push_back(find_named_attribute(scene, name));
    const std::size_t width =
        found.back() ? scene.named_attributes[named_index(*found.back())].components : 1;
    columns.push_back({name, width, {}});
    columns.back().numbers.assign(count * width, std::numeric_limits<double>::quiet_NaN());
  }
  return found;
}

}  // namespace

Status Engine::attributes(const Scene& scene, const HitBatch& hits,
                          const Column<HitDetail>& details, const HitAttributeChoice& choice,
                          const Deadline& deadline, HitAttributes& out) const {
  return within_memory([&]() -> Status {
    const std::size_t count = hits.size();
    constexpr double kNo = std::numeric_limits<double>::quiet_NaN();
    if (choice.shading_normal) out.shading_normal.assign(count, {kNo, kNo, kNo});
    if (choice.uv) out.uv.assign(count, {kNo, kNo});
    if (choice.uv1) out.uv1.assign(count, {kNo, kNo});
    if (choice.tangent) out.tangent.assign(count, {kNo, kNo, kNo, kNo});
    if (choice.colour) out.colour.assign(count, {kNo, kNo, kNo, kNo});
    const auto named = make_columns(scene.description(), choice.named, count, out.named);
    return state_->run(count, deadline, [&](std::size_t begin, std::size_t end) {
      SurfaceReader surface(scene);
      for (std::size_t i = begin; i < end; ++i) {
        if (!hits.hit(i)) continue;
        surface.go_to(hits.id(i), details[i]);
        if (choice.shading_normal) out.shading_normal[i] = surface.shading_normal();
        if (choice.uv) out.uv[i] = surface.uv();
        if (choice.colour) out.colour[i] = surface.colour();
        if (choice.uv1) out.uv1[i] = surface.uv1();
        if (choice.tangent) out.tangent[i] = surface.tangent();
        for (std::size_t k = 0; k < named.size(); ++k) {
          auto& [name, width, numbers] = out.named[k];
          if (named[k]) surface.named(*named[k], {numbers.data() + i * width, width});
        }
      }
    });
  });
}

}  // namespace sightline
