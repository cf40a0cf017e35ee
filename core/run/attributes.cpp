/// What the file says of the vertices of hits. Read for those hits alone, where it lies.

#include <limits>

#include "core/run/engine_state.h"
#include "core/scene/surface_reader.h"

namespace sightline {

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
      }
    });
  });
}

}  // namespace sightline
