#include "tests/stress/trial.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/base/infinity.h"
#include "tests/oracle/detail_check.h"
#include "tests/oracle/world_triangles.h"
#include "tests/support/float_text.h"

namespace sightline::stress {
namespace {

using oracle::OracleHit;
using test::hex;
using test::same_bits;

constexpr std::size_t kShown = 4;

std::string hex(const Vec3d& v) { return hex(v.x) + "," + hex(v.y) + "," + hex(v.z); }

double ulp_error(double t, double truth) {
  if (same_bits(t, truth) || t == truth) return 0;
  if (std::isinf(truth) || !std::isfinite(t)) return kInf;
  int exponent = 0;
  std::frexp(truth, &exponent);
  const double ulp = std::ldexp(1.0, std::max(exponent - 53, -1074));
  return std::fabs(t - truth) / ulp;
}

class Trial {
 public:
  Trial(const Family& family, std::uint64_t seed, const TrialOptions& options)
      : name_(family.name), seed_(seed), options_(options) {
    Random random(seed);
    case_ = family.make(random, options.rays);
  }

  FamilyTally run() {
    const auto start = std::chrono::steady_clock::now();
    if (const std::string fault = judge(); !fault.empty()) {
      ++tally_.sightline.any;
      tally_.failures.push_back(heading() + fault);
    }
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    tally_.seconds = spent.count();
    return std::move(tally_);
  }

 private:
  /// Empty, or why the answers could not be had.
  std::string judge() {
    RayFault ray_fault;
    if (!check_rays(case_.rays, ray_fault))
      return std::string("the family made a bad ray: ") + ray_fault.code;
    auto scene = Scene::build(case_.scene, TreeQuality::kHigh, options_.joining);
    if (!scene) return "scene: " + scene.error().message;
    auto engine = Engine::create({options_.threads, options_.kernel});
    if (!engine) return "engine: " + engine.error().message;
    const oracle::WorldTriangles triangles(**scene);
    const oracle::SceneOracle oracle(triangles.triangles);
    triangles_ = &triangles;
    oracle_ = &oracle;

    HitBatch closest;
    Column<std::uint8_t> any;
    Column<HitDetail> details;
    const Deadline never = Deadline::never();
    if (auto s = (*engine)->closest(**scene, case_.rays, never, closest); !s)
      return "closest: " + s.error().message;
    if (auto s = (*engine)->any(**scene, case_.rays, never, any); !s)
      return "any: " + s.error().message;
    if (auto s = (*engine)->details(**scene, case_.rays, closest, never, details); !s)
      return "details: " + s.error().message;

    if (std::string fault = ask_alone(**scene, **engine, closest, any); !fault.empty())
      return fault;

    std::vector<std::optional<OracleHit>> truths;
    truths.reserve(case_.rays.size());
    for (std::size_t i = 0; i < case_.rays.size(); ++i) {
      truths.push_back(oracle.closest(case_.rays[i]));
      judge_closest(i, truths[i], closest, any);
      if (truths[i] && closest.hit(i) && triangles.index(closest.id(i)) == truths[i]->triangle)
        judge_detail(i, *truths[i], details[i]);
    }
    if (std::string fault = judge_lists(**scene, **engine); !fault.empty()) return fault;
    if (case_.closed) {
      if (std::string fault = judge_parity(**scene, **engine); !fault.empty()) return fault;
    }
    judge_peers(truths);
    return {};
  }

  /// Asks each ray in a request of its own, which other code answers than a batch. Empty, or the
  /// first ray whose answer differs from that of the batch.
  std::string ask_alone(const Scene& scene, Engine& engine, const HitBatch& closest,
                        const Column<std::uint8_t>& any) const {
    const Deadline never = Deadline::never();
    for (std::size_t i = 0; i < case_.rays.size(); ++i) {
      RayBatch ray;
      ray.push_back(case_.rays[i]);
      HitBatch hit;
      Column<std::uint8_t> met;
      if (!engine.closest(scene, ray, never, hit) || !engine.any(scene, ray, never, met))
        return "a request of one ray failed";
      if (hit.id(0) != closest.id(i) || hit.t[0] != closest.t[i] || met[0] != any[i])
        return "ray " + std::to_string(i) + " has another answer alone than in the batch";
    }
    return {};
  }

  void judge_closest(std::size_t i, const std::optional<OracleHit>& truth, const HitBatch& closest,
                     const Column<std::uint8_t>& any) {
    SightlineTally& sum = tally_.sightline;
    ++sum.rays;
    if (truth) ++sum.hits;
    const bool hit = closest.hit(i);
    const char* fault = nullptr;
    if (hit && !truth) {
      ++sum.false_hits;
      fault = "false hit";
    } else if (!hit && truth) {
      ++sum.false_misses;
      fault = "false miss";
    } else if (hit && triangles_->index(closest.id(i)) != truth->triangle) {
      ++sum.wrong_primitive;
      fault = "wrong primitive";
    } else if (!same_bits(closest.t[i], truth ? truth->t_rounded : kInf)) {
      ++sum.t_bits;
      fault = "t";
    } else if ((any[i] != 0) != truth.has_value()) {
      ++sum.any;
      fault = "any";
    }
    if (fault == nullptr) return;
    std::string text = std::string(fault) + "\n  sightline ";
    text += hit ? hit_text(triangles_->index(closest.id(i)), closest.t[i]) : "misses";
    text += any[i] != 0 ? ", any: yes" : ", any: no";
    text += "\n  oracle    ";
    text += truth ? hit_text(truth->triangle, truth->t_rounded) : "misses";
    fail(i, text);
  }

  void judge_detail(std::size_t i, const OracleHit& truth, const HitDetail& detail) {
    const auto errors =
        oracle::check_detail(case_.rays[i], triangles_->triangles[truth.triangle], truth.t, detail);
    SightlineTally& sum = tally_.sightline;
    sum.worst_position_ulp = std::max(sum.worst_position_ulp, errors.position_ulp);
    sum.worst_barycentric = std::max(sum.worst_barycentric, errors.barycentric);
    sum.worst_normal = std::max(sum.worst_normal, errors.normal);
    if (errors.kept()) return;
    if (!errors.position_kept) ++sum.position;
    if (!errors.barycentric_kept) ++sum.barycentric;
    if (!errors.normal_kept) ++sum.normal;
    if (errors.front_wrong) ++sum.front;
    fail(i, "detail: position " + std::to_string(errors.position_ulp) + " ulp, barycentric " +
                hex(errors.barycentric) + ", normal " + hex(errors.normal) +
                (errors.front_wrong ? ", side wrong" : "") + "\n  sightline position " +
                hex(detail.position) + " normal " + hex(detail.normal) + " u " + hex(detail.u) +
                " v " + hex(detail.v) + "\n  oracle    " +
                hit_text(truth.triangle, truth.t_rounded));
  }

  std::string judge_lists(const Scene& scene, const Engine& engine) {
    RayBatch rays;
    std::vector<std::size_t> number;
    for (std::size_t i = 0; i < case_.rays.size(); i += options_.list_every) {
      rays.push_back(case_.rays[i]);
      number.push_back(i);
    }
    const Deadline never = Deadline::never();
    constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
    HitLists lists, once_lists, short_lists;
    Column<std::uint64_t> totals, once_totals, short_totals, counts, once_counts;
    for (const Status& s :
         {engine.all(scene, rays, {Crossings::kEvery, kAll, kAll}, never, lists, totals),
          engine.all(scene, rays, {Crossings::kOnce, kAll, kAll}, never, once_lists, once_totals),
          engine.all(scene, rays, {Crossings::kEvery, 2, kAll}, never, short_lists, short_totals),
          engine.count(scene, rays, Crossings::kEvery, never, counts),
          engine.count(scene, rays, Crossings::kOnce, never, once_counts)}) {
      if (!s) return "all or count: " + s.error().message;
    }
    SightlineTally& sum = tally_.sightline;
    for (std::size_t k = 0; k < rays.size(); ++k) {
      ++sum.lists;
      const std::vector<OracleHit> truth = oracle_->all(rays[k]);
      std::vector<OracleHit> once;
      for (const OracleHit& hit : truth) {
        if (oracle::crosses_when_moved(rays[k], triangles_->triangles[hit.triangle]))
          once.push_back(hit);
      }
      const auto cut = std::span(truth).first(std::min<std::size_t>(2, truth.size()));
      if (!same_list(lists, k, truth) || totals[k] != truth.size() ||
          !same_list(short_lists, k, cut) || short_totals[k] != truth.size()) {
        ++sum.all;
        fail(number[k], "all: " + list_text(lists, k) + "\n  oracle    " + list_text(truth));
      }
      if (!same_list(once_lists, k, once) || once_totals[k] != once.size() ||
          once_counts[k] != once.size()) {
        ++sum.once;
        fail(number[k], "once: " + list_text(once_lists, k) + "\n  oracle    " + list_text(once));
      }
      if (counts[k] != truth.size()) {
        ++sum.count;
        fail(number[k], "count: sightline " + std::to_string(counts[k]) + ", oracle " +
                            std::to_string(truth.size()));
      }
    }
    return {};
  }

  /// A closed mesh is crossed an even number of times by every whole line; an argument that needs
  /// no oracle.
  std::string judge_parity(const Scene& scene, const Engine& engine) {
    RayBatch lines;
    for (std::size_t i = 0; i < case_.rays.size(); ++i) {
      Ray ray = case_.rays[i];
      ray.tmin = -kInf;
      ray.tmax = kInf;
      lines.push_back(ray);
    }
    Column<std::uint64_t> counts;
    if (auto s = engine.count(scene, lines, Crossings::kOnce, Deadline::never(), counts); !s)
      return "count: " + s.error().message;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      ++tally_.sightline.parities;
      if (counts[i] % 2 == 0) continue;
      ++tally_.sightline.parity;
      fail(i,
           "parity: the whole line crosses a closed mesh " + std::to_string(counts[i]) + " times");
    }
    return {};
  }

  void judge_peers(const std::vector<std::optional<OracleHit>>& truths) {
    const auto peers = make_peers(triangles_->triangles);
    std::vector<std::uint32_t> near;
    for (std::size_t i = 0; i < truths.size(); ++i) {
      const Ray ray = case_.rays[i];
      const auto& truth = truths[i];
      oracle_->near(ray, near);
      for (std::size_t p = 0; p < peers.size(); ++p) {
        if (!peers[p]->accepts(ray)) continue;
        PeerTally& sum = tally_.peers[p];
        ++sum.asked;
        const auto hit = peers[p]->closest(ray, near);
        if (hit && !truth) ++sum.false_hits;
        if (!hit && truth) ++sum.false_misses;
        if (!hit || !truth) continue;
        if (hit->triangle != truth->triangle) {
          const auto t = is_finite(triangles_->triangles[hit->triangle])
                             ? oracle::least_t(ray, triangles_->triangles[hit->triangle])
                             : std::nullopt;
          if (!t || compare(*t, truth->t) != 0) {
            ++sum.wrong_primitive;
            continue;
          }
          ++sum.other_of_tie;
        }
        sum.t_error.add(ulp_error(hit->t, truth->t_rounded));
      }
    }
  }

  bool same_list(const HitLists& lists, std::size_t k, std::span<const OracleHit> truth) const {
    if (lists.first[k + 1] - lists.first[k] != truth.size()) return false;
    for (std::size_t j = 0; j < truth.size(); ++j) {
      const std::size_t slot = lists.first[k] + j;
      if (triangles_->index(lists.hits.id(slot)) != truth[j].triangle ||
          !same_bits(lists.hits.t[slot], truth[j].t_rounded))
        return false;
    }
    return true;
  }

  std::string heading() const {
    return name_ + " seed " + std::to_string(seed_) + " rays " + std::to_string(options_.rays) +
           (options_.kernel.empty() ? "" : " kernel " + options_.kernel) + ": ";
  }
  void fail(std::size_t i, const std::string& text) {
    if (tally_.failures.size() >= kShown) return;
    const Ray ray = case_.rays[i];
    tally_.failures.push_back(heading() + "ray " + std::to_string(i) + " origin " +
                              hex(ray.origin) + " direction " + hex(ray.direction) + " limits " +
                              hex(ray.tmin) + " " + hex(ray.tmax) + "\n  " + text);
  }
  std::string hit_text(std::size_t triangle, double t) const {
    const Triangle& w = triangles_->triangles[triangle];
    return "triangle " + std::to_string(triangle) + " t " + hex(t) + " corners " + hex(w.v0) +
           " | " + hex(w.v1) + " | " + hex(w.v2);
  }
  std::string list_text(const HitLists& lists, std::size_t k) const {
    std::string text;
    for (std::size_t slot = lists.first[k]; slot < lists.first[k + 1]; ++slot)
      text += std::to_string(triangles_->index(lists.hits.id(slot))) + "@" +
              hex(lists.hits.t[slot]) + " ";
    return text;
  }
  static std::string list_text(std::span<const OracleHit> hits) {
    std::string text;
    for (const OracleHit& hit : hits)
      text += std::to_string(hit.triangle) + "@" + hex(hit.t_rounded) + " ";
    return text;
  }

  std::string name_;
  std::uint64_t seed_ = 0;
  TrialOptions options_;
  Case case_;
  FamilyTally tally_;
  const oracle::WorldTriangles* triangles_ = nullptr;
  const oracle::SceneOracle* oracle_ = nullptr;
};

}  // namespace

FamilyTally run_trial(const Family& family, std::uint64_t seed, const TrialOptions& options) {
  return Trial(family, seed, options).run();
}

}  // namespace sightline::stress
