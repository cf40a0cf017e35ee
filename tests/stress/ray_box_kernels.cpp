#include <algorithm>

#include "core/trace/kernel/kernel.h"
#include "tests/stress/ray_box_cases.h"
#include "tests/support/float_text.h"

namespace sightline::stress {

namespace {

using test::same_bits;

/// The first field of slot i that is not the answer of ray_box; empty if there is none.
std::string difference(const RayBoxAnswers& batch, std::size_t i, const RayBoxAnswer& answer,
                       const PlaneTs& planes, const Vec3d& normal) {
  if (batch.outcome[i] != answer.outcome) return "outcome";
  if (!same_bits(batch.t[i], answer.t)) return "t";
  if (batch.faces.empty()) return "";
  if ((batch.inside[i] != 0) != answer.inside) return "inside";
  if ((batch.on_surface[i] != 0) != answer.on_surface) return "on_surface";
  if (batch.apart[i] != answer.apart) return "apart";
  if (!same_bits(batch.t_enter[i], answer.t_enter)) return "t_enter";
  if (!same_bits(batch.t_exit[i], answer.t_exit)) return "t_exit";
  const BoxFaces& faces = batch.faces[i];
  if (faces.count != answer.faces.count || faces.face != answer.faces.face) return "faces";
  if (!(batch.normal[i] == normal)) return "normal";
  for (std::size_t k = 0; k < 6; ++k) {
    const auto& t = batch.planes[i][k];
    if (t.has_value() != planes[k].has_value() || (t && !same_bits(*t, *planes[k])))
      return "planes";
  }
  return "";
}

}  // namespace

std::vector<RayBoxDifference> differing_kernels(std::span<const RayBoxCase> cases) {
  // Kernels decide a vector of pairs by shorter code if all of its pairs allow it, and choose the
  // code for later pairs by earlier ones. So each case is answered twice: among others, and by a
  // call with vectors of copies.
  constexpr std::size_t kCopies = 8, kCall = 64;
  RayBatch rays, copied_rays;
  BoxBatch boxes, copied_boxes;
  const auto add = [](const RayBoxCase& test, RayBatch& to_rays, BoxBatch& to_boxes) {
    to_rays.push_back(test.ray);
    if (test.oriented) {
      to_boxes.push_back(*test.oriented);
    } else {
      to_boxes.push_back(test.aligned);
    }
  };
  for (const RayBoxCase& test : cases) {
    add(test, rays, boxes);
    for (std::size_t copy = 0; copy < kCopies; ++copy) add(test, copied_rays, copied_boxes);
  }
  std::vector<RayBoxDifference> found;
  for (const Kernel& kernel : supported_kernels()) {
    for (const RayBoxDetail detail : {RayBoxDetail::kT, RayBoxDetail::kPlanes}) {
      RayBoxAnswers answers, copied;
      answers.resize(cases.size(), detail);
      kernel.ray_boxes(rays, boxes, BoxPairing::kEach, 0, cases.size(), answers);
      copied.resize(copied_rays.size(), detail);
      for (std::size_t begin = 0; begin < copied.size(); begin += kCall) {
        kernel.ray_boxes(copied_rays, copied_boxes, BoxPairing::kEach, begin,
                         std::min(copied.size(), begin + kCall), copied);
      }
      for (std::size_t i = 0; i < cases.size(); ++i) {
        const std::string field = boxes.visit_box(i, [&](const auto& box) {
          const Ray& ray = cases[i].ray;
          const RayBoxAnswer answer = ray_box(ray.origin, ray.direction, ray.tmin, ray.tmax, box);
          const PlaneTs planes = ray_box_planes(ray.origin, ray.direction, box);
          const Vec3d normal =
              answer.faces.count > 0 ? face_normal(box, answer.faces.face[0]) : Vec3d{};
          std::string differs = difference(answers, i, answer, planes, normal);
          for (std::size_t copy = 0; copy < kCopies && differs.empty(); ++copy) {
            differs = difference(copied, i * kCopies + copy, answer, planes, normal);
          }
          return differs;
        });
        if (!field.empty()) {
          found.push_back({i, "kernel " + std::string(kernel.name) + " differs in " + field});
        }
      }
    }
  }
  return found;
}

}  // namespace sightline::stress
