#include "core/trace/ray_boxes.h"

namespace sightline {

namespace {

template <class Box>
void answer_pair(const Ray& ray, const Box& box, std::size_t slot, RayBoxAnswers& answers) {
  const RayBoxAnswer answer = ray_box(ray.origin, ray.direction, ray.tmin, ray.tmax, box);
  answers.outcome[slot] = answer.outcome;
  answers.inside[slot] = answer.inside ? 1 : 0;
  answers.on_surface[slot] = answer.on_surface ? 1 : 0;
  answers.apart[slot] = answer.apart;
  answers.t[slot] = answer.t;
  answers.t_enter[slot] = answer.t_enter;
  answers.t_exit[slot] = answer.t_exit;
  answers.faces[slot] = answer.faces;
  answers.normal[slot] = answer.faces.count > 0 ? face_normal(box, answer.faces.face[0]) : Vec3d{};
  if (!answers.planes.empty()) {
    answers.planes[slot] = ray_box_planes(ray.origin, ray.direction, box);
  }
}

}  // namespace

void answer_ray_boxes(const RayBatch& rays, const BoxBatch& boxes, BoxPairing pairing,
                      std::size_t begin, std::size_t end, RayBoxAnswers& answers) {
  for (std::size_t slot = begin; slot < end; ++slot) {
    const bool each = pairing == BoxPairing::kEach;
    const Ray ray = rays[each ? slot : slot / boxes.size()];
    boxes.visit_box(each ? slot : slot % boxes.size(),
                    [&](const auto& box) { answer_pair(ray, box, slot, answers); });
  }
}

}  // namespace sightline
