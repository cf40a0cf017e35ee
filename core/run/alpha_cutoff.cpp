#include "core/run/alpha_cutoff.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/run/unbuilt_rounds.h"

namespace sightline {
namespace {

/// Rays that are asked for lists at a time.
constexpr std::size_t kRaysAtOnce = 1024;

/// The rays of some hits of a list, in the order of the hits.
RayBatch rays_of_lists(const RayBatch& rays, const HitLists& lists) {
  Column<std::size_t> numbers;
  numbers.reserve(lists.hits.size());
  for (std::size_t i = 0; i + 1 < lists.first.size(); ++i)
    numbers.insert(numbers.end(), lists.first[i + 1] - lists.first[i], i);
  return rays_of(rays, numbers);
}

}  // namespace

AlphaCutoff::AlphaCutoff(const Engine& engine, const Scene& scene, const Deadline& deadline,
                         const RayOptions& options)
    : engine_(engine), scene_(scene), deadline_(deadline), plain_(options) {
  plain_.alpha_cutoff = false;
}

const Material* AlphaCutoff::masked(TriangleId id) const {
  const SceneDescription& scene = scene_.description();
  const Mesh& mesh = *scene.meshes[scene.instances[id.instance].mesh];
  const std::uint32_t material = mesh.primitives[scene_.primitive_of(id)].material;
  if (material >= scene.materials.size()) return nullptr;
  const Material& found = scene.materials[material];
  return found.alpha_mode == AlphaMode::kMask ? &found : nullptr;
}

Status AlphaCutoff::test(const RayBatch& rays, const HitBatch& hits,
                         Column<std::uint8_t>& counts) const {
  counts.assign(hits.size(), 1);
  Column<std::size_t> numbers;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (hits.hit(i) && masked(hits.id(i)) != nullptr) numbers.push_back(i);
  }
  if (numbers.empty()) return success();
  HitBatch some;
  some.resize(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) some.copy(hits, numbers[i], i);
  Column<HitDetail> details;
  HitAttributes attributes;
  Status status = engine_.details(scene_, rays_of(rays, numbers), some, deadline_, details);
  if (status) {
    status = engine_.attributes(scene_, some, details, {.uv = true, .colour = true}, deadline_,
                                attributes);
  }
  if (!status) return status;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const Material& material = *masked(some.id(i));
    double alpha = material.base_colour[3];
    const auto& [u, v] = attributes.uv[i];
    if (material.alpha_texture != nullptr) {
      if (Status ready = material.alpha_texture->prepare(plain_.reserve); !ready) return ready;
      if (!std::isnan(u)) alpha *= material.alpha_texture->at(u, v) / 255.0;
    }
    if (!std::isnan(attributes.colour[i][3])) alpha *= attributes.colour[i][3];
    if (!(alpha >= material.alpha_cutoff)) counts[numbers[i]] = 0;
  }
  return success();
}

Status AlphaCutoff::search(const RayBatch& rays, const Column<std::size_t>& numbers,
                           HitBatch& hits) const {
  constexpr std::size_t kFirst = 8;
  Column<std::size_t> rest = numbers;
  HitLists lists;
  Column<std::uint64_t> totals;
  Column<std::uint8_t> counts;
  for (std::size_t most = kFirst; !rest.empty(); most *= kFirst) {
    const std::size_t at_once = std::max<std::size_t>(1, kRaysAtOnce * kFirst / most);
    Column<std::size_t> later;
    for (std::size_t begin = 0; begin < rest.size(); begin += at_once) {
      const std::size_t end = std::min(rest.size(), begin + at_once);
      const RayBatch some = rays_of(rays, std::span(rest).subspan(begin, end - begin));
      const HitListQuestion question{Crossings::kEvery, most,
                                     std::numeric_limits<std::size_t>::max()};
      Status status = engine_.all(scene_, some, question, deadline_, lists, totals, plain_);
      if (status) status = test(rays_of_lists(some, lists), lists.hits, counts);
      if (!status) return status;
      for (std::size_t i = 0; i < some.size(); ++i) {
        const std::size_t number = rest[begin + i];
        const auto first = counts.begin() + static_cast<std::ptrdiff_t>(lists.first[i]);
        const auto last = counts.begin() + static_cast<std::ptrdiff_t>(lists.first[i + 1]);
        const auto found = std::find(first, last, std::uint8_t{1});
        if (found != last) {
          hits.copy(lists.hits, static_cast<std::size_t>(found - counts.begin()), number);
        } else if (totals[i] > most) {
          later.push_back(number);
        } else {
          hits.t[number] = std::numeric_limits<double>::infinity();
          hits.instance[number] = hits.triangle[number] = kNone;
        }
      }
    }
    rest = std::move(later);
  }
  return success();
}

Status AlphaCutoff::closest(const RayBatch& rays, HitBatch& hits) const {
  Status status = engine_.closest(scene_, rays, deadline_, hits, plain_);
  Column<std::uint8_t> counts;
  if (status) status = test(rays, hits, counts);
  if (!status) return status;
  Column<std::size_t> rest;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) rest.push_back(i);
  }
  return search(rays, rest, hits);
}

Status AlphaCutoff::any(const RayBatch& rays, Column<std::uint8_t>& occluded) const {
  if (Status status = engine_.any(scene_, rays, deadline_, occluded, plain_); !status) {
    return status;
  }
  Column<std::size_t> numbers;
  for (std::size_t i = 0; i < occluded.size(); ++i) {
    if (occluded[i] != 0) numbers.push_back(i);
  }
  HitBatch hits;
  if (Status status = closest(rays_of(rays, numbers), hits); !status) return status;
  for (std::size_t i = 0; i < numbers.size(); ++i) occluded[numbers[i]] = hits.hit(i) ? 1 : 0;
  return success();
}

Status AlphaCutoff::count(const RayBatch& rays, Crossings crossings,
                          Column<std::uint64_t>& totals) const {
  HitLists lists;
  return all(rays, {crossings, 0, std::numeric_limits<std::size_t>::max()}, lists, totals);
}

Status AlphaCutoff::all(const RayBatch& rays, const HitListQuestion& question, HitLists& lists,
                        Column<std::uint64_t>& totals) const {
  lists.first.assign(1, 0);
  lists.hits.resize(0);
  totals.assign(rays.size(), 0);
  HitLists some_lists;
  Column<std::uint64_t> some_totals;
  Column<std::uint8_t> counts;
  Column<std::size_t> numbers(std::min(rays.size(), kRaysAtOnce));
  HitBatch one;
  one.resize(1);
  for (std::size_t begin = 0; begin < rays.size(); begin += kRaysAtOnce) {
    numbers.resize(std::min(kRaysAtOnce, rays.size() - begin));
    std::iota(numbers.begin(), numbers.end(), begin);
    const RayBatch some = rays_of(rays, numbers);
    const HitListQuestion every{question.crossings, std::numeric_limits<std::size_t>::max(),
                                question.total_max};
    Status status = engine_.all(scene_, some, every, deadline_, some_lists, some_totals, plain_);
    if (status) status = test(rays_of_lists(some, some_lists), some_lists.hits, counts);
    if (!status) return status;
    for (std::size_t i = 0; i < some.size(); ++i) {
      std::uint64_t& total = totals[begin + i];
      for (std::size_t k = some_lists.first[i]; k < some_lists.first[i + 1]; ++k) {
        if (counts[k] == 0 || total++ >= question.each_max) continue;
        one.copy(some_lists.hits, k, 0);
        lists.hits.append(one);
      }
      lists.first.push_back(lists.hits.size());
    }
    if (lists.hits.size() > question.total_max) {
      return Error{ErrorKind::kTooLarge, "TOO_MANY_HITS",
                   "the rays meet more than " + std::to_string(question.total_max) +
                       " triangles; send fewer rays or a smaller max_hits",
                   ""};
    }
  }
  return success();
}

}  // namespace sightline
