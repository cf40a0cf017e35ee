// Compiled once per instruction set, like core/trace/kernel/kernel.cpp, whose table names these
// functions.

#include "core/query/box_batch.h"
#include "core/query/ray_batch.h"
#include "core/query/ray_box_answers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <type_traits>

#include "core/trace/kernel/targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/trace/ray_boxes/ray_boxes.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.
#include <hwy/highway.h>

#include "core/trace/ray_boxes/clear_slabs-inl.h"
#include "core/trace/ray_boxes/vector_slabs-inl.h"

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

/// Pairs [begin, end), at most kBlockPairs at a time.
class PairBatches {
 public:
  PairBatches(const RayBatch& rays, const BoxBatch& boxes, BoxPairing pairing,
              RayBoxAnswers& answers)
      : rays_(rays), boxes_(boxes), each_(pairing == BoxPairing::kEach), answers_(answers) {}

  void run(std::size_t begin, std::size_t end) {
    ray_ = each_ ? begin : begin / boxes_.size();
    box_ = each_ ? begin : begin % boxes_.size();
    for (std::size_t slot = begin; slot < end; slot += kBlockPairs) {
      const std::size_t count = std::min(kBlockPairs, end - slot);
      load(count);
      if (answers_.faces.empty()) {
        decide<false>(slot, count);
      } else {
        decide<true>(slot, count);
      }
    }
  }

 private:
  static constexpr std::size_t kLanes = VectorSlabs::kLanes;
  /// After a block of which most vectors are not clear, so many are expected to be alike.
  static constexpr int kHardBlocks = 8;

  void load(std::size_t count) {
    for (std::size_t i = 0; i < count;) {
      const std::size_t run = each_ ? count - i : std::min(count - i, boxes_.size() - box_);
      load_rays(i, run);
      load_boxes(i, run);
      i += run;
      box_ += run;
      if (each_) continue;
      if (box_ == boxes_.size()) {
        box_ = 0;
        ++ray_;
      }
    }
  }
  void load_rays(std::size_t first, std::size_t count) {
    const auto copy = [&](const UnsetColumn<double>& from, double* to) {
      if (!each_) {
        std::fill_n(to + first, count, from[ray_]);
      } else if (count == kBlockPairs) {
        // Of constant length: without a call.
        std::copy_n(from.data() + ray_, kBlockPairs, to);
      } else {
        std::copy_n(from.data() + ray_, count, to + first);
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
  /// A box that is not aligned is empty in boxes_.aligned: with infinite sides, and some that the
  /// ray is not parallel to, so that the vectors leave the pair to ray_box.
  void load_boxes(std::size_t first, std::size_t count) {
    std::size_t i = 0;
#if HWY_TARGET != HWY_SCALAR
    const hn::CappedTag<double, 8> d;
    for (; i + kLanes <= count; i += kLanes) {
      // Box3d is six numbers: x, y, z of the lower corner, then of the upper one.
      const auto* const from = reinterpret_cast<const double*>(&boxes_.aligned[box_ + i]);
      hn::Vec<decltype(d)> a[3], b[3];
      hn::LoadInterleaved3(d, from, a[0], a[1], a[2]);
      hn::LoadInterleaved3(d, from + 3 * kLanes, b[0], b[1], b[2]);
      SIGHTLINE_UNROLL
      for (int k = 0; k < 3; ++k) {
        hn::StoreU(hn::ConcatEven(d, b[k], a[k]), d, pairs_.lower[k] + first + i);
        hn::StoreU(hn::ConcatOdd(d, b[k], a[k]), d, pairs_.upper[k] + first + i);
      }
    }
#endif
    for (; i < count; ++i) {
      const Box3d& box = boxes_.aligned[box_ + i];
      for (int k = 0; k < 3; ++k) {
        pairs_.lower[k][first + i] = box.min[k];
        pairs_.upper[k][first + i] = box.max[k];
      }
    }
  }

  template <bool kAll>
  void decide(std::size_t slot, std::size_t count) {
    const hn::CappedTag<double, 8> d;
    std::uint64_t left = 0;  // the first pairs of vectors that are not clear
    if (hard_blocks_ > 0) {
      --hard_blocks_;
      for (std::size_t i = 0; i < count; i += kLanes) left |= std::uint64_t{1} << i;
    } else {
      left = decide_clear<kAll>(count);
      const auto vectors = static_cast<std::size_t>(std::popcount(left));
      if (2 * vectors * kLanes > count) hard_blocks_ = kHardBlocks;
    }
    std::uint64_t open = 0;
    for (; left != 0; left &= left - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(left));
      const auto decided = VectorSlabs::decide<kAll>(pairs_, i, found_);
      open |= std::uint64_t{mask_bits(d, hn::Not(decided))} << i;
    }
    std::copy_n(found_.t, count, answers_.t.data() + slot);
    namespace pc = pair_code;
    const auto unpack_bits = [&](auto& column, auto part) {
      // Of constant length: compilers pack the codes by vectors.
      std::array<std::decay_t<decltype(column[0])>, kBlockPairs> parts;
      for (std::size_t i = 0; i < kBlockPairs; ++i) parts[i] = part(found_.code[i]);
      std::copy_n(parts.data(), count, column.data() + slot);
    };
    unpack_bits(answers_.outcome,
                [](std::uint64_t code) { return static_cast<RayBoxOutcome>(code & pc::kOutcome); });
    if constexpr (kAll) {
      std::copy_n(found_.t_enter, count, answers_.t_enter.data() + slot);
      std::copy_n(found_.t_exit, count, answers_.t_exit.data() + slot);
      const auto bit = [](int shift) {
        return [shift](std::uint64_t code) { return static_cast<std::uint8_t>(code >> shift & 1); };
      };
      unpack_bits(answers_.inside, bit(pc::kInside));
      unpack_bits(answers_.on_surface, bit(pc::kOnSurface));
      for (std::size_t i = 0; i < count; ++i) unpack_faces(slot + i, found_.code[i]);
    }
    if (count < kBlockPairs) open &= (std::uint64_t{1} << count) - 1;
    for (; open != 0; open &= open - 1) {
      answer_alone(slot + static_cast<std::size_t>(std::countr_zero(open)));
    }
    if (!answers_.planes.empty()) {
      for (std::size_t i = 0; i < count; ++i) answer_planes(slot + i);
    }
  }

  /// Answers the vectors of pairs whose comparisons are clear. Returns the first pair of each other
  /// vector, as bits.
  template <bool kAll>
  std::uint64_t decide_clear(std::size_t count) {
    std::uint64_t left = 0;
    for (std::size_t i = 0; i < count; i += kLanes) {
      if (!ClearSlabs::decide<kAll>(pairs_, i, enters_, exits_, found_.code))
        left |= std::uint64_t{1} << i;
    }
    for (std::size_t i = 0; i < count; i += kLanes) {
      bool certain = ClearSlabs::round(enters_, i, kAll ? found_.t_enter : found_.t);
      if (kAll) certain = ClearSlabs::round(exits_, i, found_.t_exit) && certain;
      if (!certain) left |= std::uint64_t{1} << i;
    }
    if constexpr (kAll) {
      for (std::size_t i = 0; i < kBlockPairs; ++i) {
        const std::uint64_t code = found_.code[i];
        const double met =
            (code >> pair_code::kLeaving & 1) != 0 ? found_.t_exit[i] : found_.t_enter[i];
        found_.t[i] = (code & pair_code::kOutcome) == 0 ? met : 0;
      }
    }
    return left;
  }

  /// Without branches on the outcome, which cannot be predicted.
  void unpack_faces(std::size_t slot, std::uint64_t code) {
    namespace pc = pair_code;
    answers_.apart[slot] = pc::kApart[code & (pc::kApart.size() - 1)];
    BoxFaces& faces = answers_.faces[slot];
    faces = pc::kFaces[code >> pc::kLeaving & (pc::kFaces.size() - 1)];
    for (std::uint64_t along = code >> pc::kAlong; along != 0; along &= along - 1) {
      const int bit = std::countr_zero(along);
      faces.add({static_cast<std::uint8_t>(bit >> 1), (bit & 1) != 0});
    }
    // In place: a copy would load 16 bytes that two stores of 8 have just written, which stalls.
    Vec3d& normal = answers_.normal[slot];
    normal = {};
    const BoxFace first = faces.face[0];
    constexpr double kSigns[2][2] = {{0, 0}, {-1, 1}};
    normal[first.axis] = kSigns[faces.count > 0 ? 1 : 0][first.upper ? 1 : 0];
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
  int hard_blocks_ = 0;            ///< for so many blocks ClearSlabs is not tried
  PairColumns pairs_{};
  Crossings enters_{}, exits_{};
  PairAnswers found_{};
};

}  // namespace

void answer_ray_boxes(const RayBatch& rays, const BoxBatch& boxes, BoxPairing pairing,
                      std::size_t begin, std::size_t end, RayBoxAnswers& answers) {
  if (begin < end) PairBatches(rays, boxes, pairing, answers).run(begin, end);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();
