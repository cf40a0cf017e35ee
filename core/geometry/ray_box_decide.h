#pragma once
/// The rules of ray_box.h as one template for axis-aligned and oriented boxes.
///
/// The template argument Slabs represents a ray and a box. It must offer these functions for k = 0,
/// 1, 2 and planes {k, upper}, all of them exact:
///   parallel(k)          true if the line does not cross the planes of slab k
///   lower_first(k)       true if the line passes the lower plane first; not called if parallel
///   bounded(plane)       true if the plane exists (a box may be open on that side)
///   depth_sign(plane)    sign of how far inside of the plane the origin is; +1 if not bounded
///   order(a, b)          sign of t(a) - t(b); both planes are bounded and not parallel
///   order(a, limit)      sign of t(a) - limit for such a plane; the limit may be infinite
///   rounded(a)           t(a) of such a plane, rounded once; zero is +0

#include "core/geometry/ray_box.h"
#include "core/geometry/rounding.h"

namespace sightline::ray_box_detail {

/// Computes one answer. Usage: Decision(slabs, tmin, tmax).answer(). Refers to `slabs`, which must
/// outlive it. answer() may be called once.
template <class Slabs>
class Decision {
 public:
  Decision(const Slabs& slabs, double tmin, double tmax)
      : slabs_(slabs), tmin_(tmin), tmax_(tmax) {}

  RayBoxAnswer answer() {
    place_origin();
    for (std::uint8_t k = 0; k < 3; ++k) {
      if (slabs_.parallel(k) &&
          (slabs_.depth_sign({k, false}) < 0 || slabs_.depth_sign({k, true}) < 0)) {
        return miss(RayBoxOutcome::kBeside, k, k);
      }
    }
    find_span();
    if (has_enter_ && has_exit_ && slabs_.order(enter_, exit_) > 0) {
      return miss(RayBoxOutcome::kApart, enter_.axis, exit_.axis);
    }
    answer_.t_enter = has_enter_ ? slabs_.rounded(enter_) : -kInfD;
    answer_.t_exit = has_exit_ ? slabs_.rounded(exit_) : kInfD;
    if (has_exit_ && slabs_.order(exit_, tmin_) < 0) return miss(RayBoxOutcome::kBehind, 0, 0);
    if (has_enter_ && slabs_.order(enter_, tmax_) > 0) return miss(RayBoxOutcome::kBeyond, 0, 0);
    answer_.outcome = RayBoxOutcome::kHit;
    choose_t();
    return answer_;
  }

 private:
  RayBoxAnswer miss(RayBoxOutcome outcome, std::uint8_t a, std::uint8_t b) {
    answer_.outcome = outcome;
    answer_.apart = {a < b ? a : b, a < b ? b : a};
    return answer_;
  }

  BoxFace near_plane(std::uint8_t k) const { return {k, !slabs_.lower_first(k)}; }
  BoxFace far_plane(std::uint8_t k) const { return {k, slabs_.lower_first(k)}; }

  /// Sets `inside` and `on_surface` of the answer.
  void place_origin() {
    bool strict = true;
    for (std::uint8_t k = 0; k < 3; ++k) {
      const int low = slabs_.depth_sign({k, false});
      const int high = slabs_.depth_sign({k, true});
      if (low < 0 || high < 0) return;
      strict = strict && low > 0 && high > 0;
    }
    answer_.inside = strict;
    answer_.on_surface = !strict;
  }

  /// Finds the last entry and the first exit. Of planes with equal t it takes that of the smaller
  /// axis.
  void find_span() {
    for (std::uint8_t k = 0; k < 3; ++k) {
      if (slabs_.parallel(k)) continue;
      const BoxFace near = near_plane(k);
      const BoxFace far = far_plane(k);
      if (slabs_.bounded(near) && (!has_enter_ || slabs_.order(near, enter_) > 0)) {
        enter_ = near;
        has_enter_ = true;
      }
      if (slabs_.bounded(far) && (!has_exit_ || slabs_.order(far, exit_) < 0)) {
        exit_ = far;
        has_exit_ = true;
      }
    }
  }

  /// Sets t and faces. Precondition: the ray meets the box, so enter <= tmax and exit >= tmin.
  void choose_t() {
    const bool exit_in_limits = has_exit_ && slabs_.order(exit_, tmax_) <= 0;
    if (answer_.on_surface && tmin_ <= 0 && tmax_ >= 0) {
      answer_.t = 0;
      collect_faces([&](BoxFace plane) { return slabs_.depth_sign(plane) == 0; }, false);
    } else if (answer_.inside && exit_in_limits) {
      answer_.t = answer_.t_exit;
      collect_faces([&](BoxFace plane) { return meets(plane, exit_); }, true);
    } else if (has_enter_ && slabs_.order(enter_, tmin_) >= 0) {
      answer_.t = answer_.t_enter;
      collect_faces([&](BoxFace plane) { return meets(plane, enter_); }, false);
    } else if (exit_in_limits) {
      answer_.t = answer_.t_exit;
      collect_faces([&](BoxFace plane) { return meets(plane, exit_); }, true);
    } else {
      answer_.t = kInfD;
    }
  }

  /// True if the line crosses `plane` at the t of `at`.
  bool meets(BoxFace plane, BoxFace at) const {
    return plane == at || slabs_.order(plane, at) == 0;
  }

  /// Lists the faces that satisfy `holds` in the order that RayBoxAnswer::faces states; `leaving`:
  /// the ray is on its way out.
  template <class Holds>
  void collect_faces(Holds holds, bool leaving) {
    for (const bool far : {leaving, !leaving}) {
      for (std::uint8_t k = 0; k < 3; ++k) {
        if (slabs_.parallel(k)) continue;
        const BoxFace plane = far ? far_plane(k) : near_plane(k);
        if (slabs_.bounded(plane) && holds(plane)) answer_.faces.add(plane);
      }
    }
    for (std::uint8_t k = 0; k < 3; ++k) {
      if (!slabs_.parallel(k)) continue;
      for (const bool upper : {false, true}) {
        if (slabs_.depth_sign({k, upper}) == 0) answer_.faces.add({k, upper});
      }
    }
  }

  const Slabs& slabs_;
  const double tmin_;
  const double tmax_;
  RayBoxAnswer answer_;
  bool has_enter_ = false;
  bool has_exit_ = false;
  BoxFace enter_;
  BoxFace exit_;
};

/// The t of the six planes, as ray_box_planes returns them. Precondition: that of Decision for
/// Slabs.
template <class Slabs>
PlaneTs planes_of(const Slabs& slabs) {
  PlaneTs out;
  for (std::uint8_t k = 0; k < 3; ++k) {
    if (slabs.parallel(k)) continue;
    for (const bool upper : {false, true}) {
      const BoxFace plane{k, upper};
      if (slabs.bounded(plane)) out[2u * k + (upper ? 1u : 0u)] = slabs.rounded(plane);
    }
  }
  return out;
}

}  // namespace sightline::ray_box_detail

// Tests: tests/unit/geometry/ray_box_test.cpp
