// Compiled once per instruction set, like kernel.cpp, whose table names these functions.

#include "core/query/box_batch.h"
#include "core/query/ray_batch.h"
#include "core/query/ray_box_answers.h"

#include <algorithm>
#include <bit>

#include "core/trace/kernel/targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/trace/kernel/ray_boxes.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.
#include <hwy/highway.h>

#include "core/trace/kernel/ray_boxes-inl.h"

#ifndef SIGHTLINE_TRACE_RAY_BOXES_ONCE
#define SIGHTLINE_TRACE_RAY_BOXES_ONCE
namespace sightline {

/// One pair alone.
inline void answer_pair(const Ray& ray, const auto& box, std::size_t slot, RayBoxAnswers& answers) {
  const RayBoxAnswer answer = ray_box(ray.origin, ray.direction, ray.tmin, ray.tmax, box);
  answers.outcome[slot] = answer.outcome;
  answers.t[slot] = answer.t;
  if (answers.faces.empty()) return;
  answers.inside[slot] = answer.inside ? 1 : 0;
  answers.on_surface[slot] = answer.on_surface ? 1 : 0;
  answers.apart[slot] = answer.apart;
  answers.t_enter[slot] = answer.t_enter;
  answers.t_exit[slot] = answer.t_exit;
  answers.faces[slot] = answer.faces;
  answers.normal[slot] = answer.faces.count > 0 ? face_normal(box, answer.faces.face[0]) : Vec3d{};
}

}  // namespace sightline
#endif

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

namespace {

/// Pairs [begin, end), at most PairColumns::kPairs at a time.
class PairBatches {
 public:
  PairBatches(const RayBatch& rays, const BoxBatch& boxes, BoxPairing pairing,
              RayBoxAnswers& answers)
      : rays_(rays), boxes_(boxes), each_(pairing == BoxPairing::kEach), answers_(answers) {}

  void run(std::size_t begin, std::size_t end) {
    ray_ = each_ ? begin : begin / boxes_.size();
    box_ = each_ ? begin : begin % boxes_.size();
    for (std::size_t slot = begin; slot < end; slot += PairColumns::kPairs) {
      const std::size_t count = std::min(PairColumns::kPairs, end - slot);
      load(count);
      if (answers_.faces.empty()) {
        decide<false>(slot, count);
      } else {
        decide<true>(slot, count);
      }
    }
  }

 private:
  void load(std::size_t count) {
    for (std::size_t i = 0; i < count;) {
      const std::size_t run = each_ ? count - i : std::min(count - i, boxes_.size() - box_);
      load_rays(i, run);
      for (const std::size_t stop = i + run; i < stop; ++i, ++box_) load_box(i);
      if (each_) continue;
      if (box_ == boxes_.size()) {
        box_ = 0;
        ++ray_;
      }
    }
  }
  void load_rays(std::size_t first, std::size_t count) {
    const auto copy = [&](const UnsetColumn<double>& from, double* to) {
      if (each_) {
        std::copy_n(from.data() + ray_, count, to + first);
      } else {
        std::fill_n(to + first, count, from[ray_]);
      }
    };
    copy(rays_.ox, pairs_.origin[0]);
    copy(rays_.oy, pairs_.origin[1]);
    copy(rays_.oz, pairs_.origin[2]);
    copy(rays_.dx, pairs_.direction[0]);
    copy(rays_.dy, pairs_.direction[1]);
    copy(rays_.dz, pairs_.direction[2]);
    copy(rays_.tmin, pairs_.tmin);
    copy(rays_.tmax, pairs_.tmax);
    if (each_) ray_ += count;
  }
  void load_box(std::size_t i) {
    const bool aligned = boxes_.is_aligned(box_);
    const Box3d& box = boxes_.aligned[box_];
    for (int k = 0; k < 3; ++k) {
      // An infinite side: the vectors leave the pair to ray_box.
      pairs_.lower[k][i] = aligned ? box.min[k] : -kInfD;
      pairs_.upper[k][i] = box.max[k];
    }
  }

  template <bool kAll>
  void decide(std::size_t slot, std::size_t count) {
    const hn::CappedTag<double, 8> d;
    constexpr std::size_t kLanes = VectorSlabs::kLanes;
    HWY_ALIGN double t[PairColumns::kPairs], t_enter[PairColumns::kPairs],
        t_exit[PairColumns::kPairs];
    HWY_ALIGN std::uint64_t code[PairColumns::kPairs];
    std::uint64_t open = 0;
    for (std::size_t i = 0; i < count; i += kLanes) {
      const auto decided = VectorSlabs::decide<kAll>(pairs_, i, t, t_enter, t_exit, code);
      open |= std::uint64_t{mask_bits(d, hn::Not(decided))} << i;
    }
    std::copy_n(t, count, answers_.t.data() + slot);
    for (std::size_t i = 0; i < count; ++i) {
      answers_.outcome[slot + i] = static_cast<RayBoxOutcome>(code[i] & pair_code::kOutcome);
    }
    if constexpr (kAll) {
      std::copy_n(t_enter, count, answers_.t_enter.data() + slot);
      std::copy_n(t_exit, count, answers_.t_exit.data() + slot);
      for (std::size_t i = 0; i < count; ++i) unpack(slot + i, code[i]);
    }
    if (count < PairColumns::kPairs) open &= (std::uint64_t{1} << count) - 1;
    for (; open != 0; open &= open - 1) {
      answer_alone(slot + static_cast<std::size_t>(std::countr_zero(open)));
    }
    if (!answers_.planes.empty()) {
      for (std::size_t i = 0; i < count; ++i) answer_planes(slot + i);
    }
  }

  void unpack(std::size_t slot, std::uint64_t code) {
    namespace pc = pair_code;
    answers_.inside[slot] = (code & pc::kInside) != 0;
    answers_.on_surface[slot] = (code & pc::kOnSurface) != 0;
    std::uint8_t a = code >> pc::kEnterAxis & 3, b = code >> pc::kExitAxis & 3;
    const bool apart = (code & pc::kOutcome) == static_cast<std::uint64_t>(RayBoxOutcome::kApart);
    answers_.apart[slot] = {};
    if (apart) answers_.apart[slot] = {std::min(a, b), std::max(a, b)};
    const BoxFaces& faces = pc::kFaces[code >> pc::kLeaving & (pc::kFaces.size() - 1)];
    answers_.faces[slot] = faces;
    // In place: a copy would load 16 bytes that two stores of 8 have just written, which stalls.
    Vec3d& normal = answers_.normal[slot];
    normal = {};
    if (faces.count > 0) normal[faces.face[0].axis] = faces.face[0].upper ? 1 : -1;
  }

  std::size_t ray_of(std::size_t slot) const { return each_ ? slot : slot / boxes_.size(); }
  std::size_t box_of(std::size_t slot) const { return each_ ? slot : slot % boxes_.size(); }
  HWY_NOINLINE void answer_alone(std::size_t slot) {
    const Ray ray = rays_[ray_of(slot)];
    boxes_.visit_box(box_of(slot), [&](const auto& box) { answer_pair(ray, box, slot, answers_); });
  }
  HWY_NOINLINE void answer_planes(std::size_t slot) {
    const Ray ray = rays_[ray_of(slot)];
    boxes_.visit_box(box_of(slot), [&](const auto& box) {
      answers_.planes[slot] = ray_box_planes(ray.origin, ray.direction, box);
    });
  }

  const RayBatch& rays_;
  const BoxBatch& boxes_;
  const bool each_;
  RayBoxAnswers& answers_;
  std::size_t ray_ = 0, box_ = 0;  ///< of the next pair
  PairColumns pairs_{};
};

}  // namespace

void answer_ray_boxes(const RayBatch& rays, const BoxBatch& boxes, BoxPairing pairing,
                      std::size_t begin, std::size_t end, RayBoxAnswers& answers) {
  if (begin < end) PairBatches(rays, boxes, pairing, answers).run(begin, end);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();
