#include "tests/crosscheck/judge.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <thread>

#include "tests/support/float_text.h"

namespace sightline::crosscheck {
namespace {

using test::hex;

constexpr std::size_t kShown = 5;

std::string hex(const Vec3d& v) { return "(" + hex(v.x) + "," + hex(v.y) + "," + hex(v.z) + ")"; }

class Judge {
 public:
  Judge(const RayBatch& rays, const Answers& answers, const EmbreeScene& embree,
        const oracle::SceneOracle& oracle, const oracle::WorldTriangles& triangles)
      : rays_(rays), answers_(answers), embree_(embree), oracle_(oracle), triangles_(triangles) {}

  void look_at(std::size_t i, bool sampled, Verdict& verdict) const {
    const Ray ray = rays_[i];
    const bool hit = answers_.closest.hit(i);
    const auto embree_hit = embree_.closest(ray);
    const bool embree_any = embree_.any(ray);
    ++verdict.rays;
    verdict.hits += hit ? 1 : 0;
    const bool consistent = (answers_.any[i] != 0) == hit;
    const bool agree = consistent && embree_hit.has_value() == hit && embree_any == hit &&
                       (!hit || triangles_.id(embree_hit->triangle) == answers_.closest.id(i));
    if (agree && !sampled) return;

    ++verdict.judged;
    const auto truth = oracle_.closest(ray);
    const bool right = consistent && truth.has_value() == hit &&
                       (hit ? triangles_.id(truth->triangle) == answers_.closest.id(i) &&
                                  same_bits(truth->t_rounded, answers_.closest.t[i])
                            : answers_.closest.t[i] == std::numeric_limits<double>::infinity());
    if (!right) {
      ++verdict.sightline_wrong;
      if (verdict.wrong.size() < kShown) verdict.wrong.push_back(describe(i, truth));
    }
    if (embree_hit.has_value() != truth.has_value() || embree_any != truth.has_value()) {
      ++verdict.embree_wrong;
    } else if (truth && embree_hit->triangle != truth->triangle) {
      const auto t = oracle::least_t(ray, triangles_.triangles[embree_hit->triangle]);
      const bool tie = t && compare(*t, truth->t) == 0;
      ++(tie ? verdict.tie : verdict.embree_wrong);
    }
  }

 private:
  static bool same_bits(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  }

  std::string describe(std::size_t i, const std::optional<oracle::OracleHit>& truth) const {
    const Ray ray = rays_[i];
    std::string text = "ray " + std::to_string(i) + " origin " + hex(ray.origin) + " direction " +
                       hex(ray.direction) + " limits " + hex(ray.tmin) + " " + hex(ray.tmax);
    text += "\n  sightline: ";
    text +=
        answers_.closest.hit(i) ? hit_text(answers_.closest.id(i), answers_.closest.t[i]) : "miss";
    text += answers_.any[i] != 0 ? ", any yes" : ", any no";
    text += "\n  oracle:    ";
    text += truth ? hit_text(triangles_.id(truth->triangle), truth->t_rounded) : "miss";
    return text;
  }
  std::string hit_text(TriangleId id, double t) const {
    const oracle::Triangle& w = triangles_.triangles[triangles_.index(id)];
    return std::to_string(id.instance) + "/" + std::to_string(id.triangle) + " t " + hex(t) +
           " corners " + hex(w.v0) + " " + hex(w.v1) + " " + hex(w.v2);
  }

  const RayBatch& rays_;
  const Answers& answers_;
  const EmbreeScene& embree_;
  const oracle::SceneOracle& oracle_;
  const oracle::WorldTriangles& triangles_;
};

}  // namespace

void Verdict::add(const Verdict& other) {
  rays += other.rays;
  hits += other.hits;
  judged += other.judged;
  sightline_wrong += other.sightline_wrong;
  embree_wrong += other.embree_wrong;
  tie += other.tie;
  for (const std::string& text : other.wrong) {
    if (wrong.size() < kShown) wrong.push_back(text);
  }
}

std::string Verdict::lines() const {
  return "sightline wrong " + std::to_string(sightline_wrong) + "\nembree wrong " +
         std::to_string(embree_wrong) + "\ntie " + std::to_string(tie) + "\n";
}

Verdict judge(const RayBatch& rays, const Answers& answers, const EmbreeScene& embree,
              const oracle::SceneOracle& oracle, const oracle::WorldTriangles& triangles,
              std::size_t sample_every) {
  constexpr std::size_t kThreads = 2;
  const Judge one(rays, answers, embree, oracle, triangles);
  std::array<Verdict, kThreads> verdicts;
  {
    std::vector<std::jthread> threads;
    for (std::size_t k = 0; k < kThreads; ++k) {
      threads.emplace_back([&, k] {
        // Blocks, so that both threads meet cheap and dear rays.
        constexpr std::size_t kBlock = 256;
        for (std::size_t i = k * kBlock; i < rays.size(); i += kThreads * kBlock) {
          const std::size_t end = std::min(i + kBlock, rays.size());
          for (std::size_t r = i; r < end; ++r) one.look_at(r, r % sample_every == 0, verdicts[k]);
        }
      });
    }
  }
  Verdict total;
  for (const Verdict& verdict : verdicts) total.add(verdict);
  return total;
}

}  // namespace sightline::crosscheck
