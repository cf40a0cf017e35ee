#include "server/service/image_answer.h"

#include <algorithm>
#include <cmath>

#include "core/base/watch.h"
#include "core/base/within_memory.h"
#include "core/query/ray_generators.h"
#include "core/trace/inspect/explain.h"
#include "proto/node_colour.h"
#include "server/service/answer_memory.h"
#include "server/service/hit_terms.h"

namespace sightline {
namespace {

constexpr std::size_t kMostBoxes = 65'535;  // what a sample of a PNG holds

/// Some rows of the picture on their way. The columns are used again by the next rows.
struct PictureRows {
  RayBatch rays;
  HitBatch hits;
  Column<double> distance;
  Column<Vec3d> normal;
  Column<std::uint32_t> visits;
  Column<Vec3d> colour;
  HitTerms terms;
};
/// Of a pixel in all of these.
constexpr std::uint64_t kPixelBytes =
    kRayBytes + kHitBytes + sizeof(double) + 2 * sizeof(Vec3d) + 8;

/// Rows that are traced at once: enough rays for all threads, few enough for their caches.
std::uint64_t rows_at_once(const HitImage& image) {
  constexpr std::uint64_t kRays = 32'768, kSquare = 8;
  const std::uint64_t rows = kRays / std::max<std::uint64_t>(1, image.width) / kSquare * kSquare;
  return std::clamp(rows, kSquare, std::max(image.height, kSquare));
}

/// Counts the boxes that explain_ray lists for each ray.
Status count_visits(const Scene& scene, const RayBatch& rays, const RayOptions& options,
                    const Deadline& deadline, Column<std::uint32_t>& visits) {
  const SceneView view(scene);
  DeadlineWatch watch(deadline);
  visits.resize(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto boxes = explain_ray(view, rays[i], options.resolved, kMostBoxes).boxes.size();
    visits[i] = static_cast<std::uint32_t>(boxes);
    if (watch.passed(boxes + 1)) return watch.error();
  }
  return success();
}

/// The colours of nodes, as light: the table is for screens, whose parts are about squares.
void colour_nodes(PictureRows& rows) {
  rows.colour.assign(rows.hits.size(), Vec3d{});
  for (std::size_t i = 0; i < rows.hits.size(); ++i) {
    if (!rows.hits.hit(i)) continue;
    const auto colour = node_colour(rows.terms.node[i]);
    for (int k = 0; k < 3; ++k) {
      const double part = colour[static_cast<std::size_t>(k)] / 255.0;
      rows.colour[i][k] = part * part;
    }
  }
}

/// Base colours with a light at the camera.
void shade(const SceneDescription& scene, PictureRows& rows) {
  rows.colour.assign(rows.hits.size(), Vec3d{});
  for (std::size_t i = 0; i < rows.hits.size(); ++i) {
    if (!rows.hits.hit(i)) continue;
    const Vec3d &d = rows.rays[i].direction, &n = rows.normal[i];
    const double along =
        std::fabs(d.x * n.x + d.y * n.y + d.z * n.z) / std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    const std::uint32_t material = rows.terms.material[i];
    for (int k = 0; k < 3; ++k) {
      const double base = material < scene.materials.size()
                              ? scene.materials[material].base_colour[static_cast<std::size_t>(k)]
                              : 1;
      rows.colour[i][k] = base * (0.25 + 0.75 * along);
    }
  }
}

Status draw_picture(const Service& service, const Scene& scene, const RayQuery& query,
                    const RayOptions& options, const Deadline& deadline, WorkTimer& timer,
                    HitImageEncoder& encoder) {
  const HitImage& image = *query.image;
  PictureRows rows;
  const std::uint64_t step = rows_at_once(image);
  for (std::uint64_t begin = 0; begin < image.height; begin += step) {
    const std::uint64_t end = std::min(image.height, begin + step);
    Status status = generate_rows(*query.camera, begin, end, rows.rays);
    if (!status) return status;
    if (query.normalize) scale_limits_to_t(rows.rays);
    timer.add(&WorkReport::parse_us);
    status = service.engine.closest(scene, rows.rays, deadline, rows.hits, options);
    timer.add(&WorkReport::trace_us);
    const bool is_shaded = image.of == HitImage::Of::kShaded;
    if (status && (image.of == HitImage::Of::kNormal || is_shaded)) {
      status = service.engine.normals(scene, rows.hits, deadline, rows.normal);
    }
    if (status && image.of == HitImage::Of::kVisits) {
      status = count_visits(scene, rows.rays, options, deadline, rows.visits);
    }
    if (!status) return status;
    if (image.of == HitImage::Of::kNode || image.of == HitImage::Of::kNodeColours) {
      rows.terms = hit_terms(scene, rows.hits, {HitField::kNodeId});
    }
    if (is_shaded) rows.terms = hit_terms(scene, rows.hits, {HitField::kMaterialId});
    if (image.of == HitImage::Of::kNodeColours) colour_nodes(rows);
    if (is_shaded) shade(scene.description(), rows);
    if (image.of == HitImage::Of::kDepth && query.normalize) {
      rows.distance.resize(rows.hits.size());
      for (std::size_t i = 0; i < rows.hits.size(); ++i)
        rows.distance[i] = distance_of(rows.hits.t[i], rows.rays[i].direction);
    }
    timer.add(&WorkReport::describe_us);
    const auto& depth = query.normalize ? rows.distance : rows.hits.t;
    status = encoder.draw(
        begin, end, {rows.hits, depth, rows.terms.node, rows.normal, rows.visits, rows.colour});
    if (!status) return status;
    timer.add(&WorkReport::print_us);
  }
  return success();
}

}  // namespace

Result<std::string> answer_image(const Service& service, const Scene& scene, const RayQuery& query,
                                 const RayOptions& options, const Deadline& deadline,
                                 WorkTimer& timer) {
  const HitImage& image = *query.image;
  Status status = HitImageEncoder::check(image);
  const std::uint64_t rows = rows_at_once(image);
  const bool explains = image.of == HitImage::Of::kVisits;
  if (status) {
    status =
        ask_for(options.reserve, HitImageEncoder::bytes(image) + rows * image.width * kPixelBytes +
                                     (explains ? kMostBoxes * sizeof(ExplainedBox) : 0));
  }
  std::string picture;
  if (status) {
    status = within_memory("there is no memory for the picture", [&]() -> Status {
      HitImageEncoder encoder(image);
      Status drawn = draw_picture(service, scene, query, options, deadline, timer, encoder);
      if (!drawn) return drawn;
      auto file = encoder.finish();
      if (!file) return file.error();
      picture = std::move(*file);
      return success();
    });
  }
  return status ? Result<std::string>(std::move(picture)) : status.error();
}

}  // namespace sightline
