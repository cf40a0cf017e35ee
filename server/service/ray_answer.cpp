#include "server/service/ray_answer.h"

#include <algorithm>

#include "core/base/infinity.h"
#include "core/base/watch.h"
#include "core/query/range_noise.h"
#include "core/run/nearest_miss.h"
#include "core/trace/inspect/explain.h"
#include "core/trace/kernel/all_hits.h"
#include "proto/binary/hit_binary.h"
#include "proto/binary/hit_table.h"
#include "proto/json/hit_json.h"
#include "proto/json/hit_lines.h"
#include "server/service/answer_memory.h"
#include "server/service/hit_terms.h"
#include "server/service/image_answer.h"
#include "server/service/tree_json.h"

namespace sightline {
namespace {

/// One batch on its way.
struct RayBatchCourse {
  const Service& service;
  const Scene& scene;
  const RayQuery& query;
  const RayOptions& options;
  const Deadline& deadline;
  const ReserveBytes& reserve;
  WorkTimer& timer;

  /// The bad rays, where they are to be marked; else null.
  const InvalidRays* invalid() const { return query.marks_invalid ? &query.invalid : nullptr; }
  bool is(AnswerLayout layout) const { return query.layout == layout; }

  Status describe(const RayBatch& rays, const HitBatch& hits, HitDescription& about) const {
    Status status = describe_within(
        reserve, service.engine,
        {scene, rays, hits, query.fields, query.normalize, options.resolved, query.named_fields},
        deadline, about);
    timer.add(&WorkReport::describe_us);
    return status;
  }
};

/// The first `most` hits of each ray, and how many there are.
Status list_hits(const RayBatchCourse& course, std::uint64_t most, HitLists& lists,
                 Column<std::uint64_t>& totals) {
  const RayBatch& rays = course.query.rays;
  const Engine& engine = course.service.engine;
  const auto at_once =
      std::min<std::uint64_t>(rays.size(), static_cast<std::uint64_t>(engine.threads()));
  std::uint64_t kept = 0;
  // The lists of the threads, and all of them joined.
  return search_lists(
      course.reserve, rays.size(), course.service.limits.hits, 3 * kHitBytes,
      [&](std::uint64_t granted) {
        const std::uint64_t keeps = at_once * std::min(most, granted) * AllHits::kBytesOfHit;
        Status status = ask_for(course.reserve, keeps - kept);
        if (!status) return status;
        kept = keeps;
        return engine.all(course.scene, rays, {course.query.crossings, most, granted},
                          course.deadline, lists, totals, course.options);
      });
}

/// As many slots for each ray, its first hits in them and then misses; `rays` has the ray of each.
Status find_returns(const RayBatchCourse& course, HitBatch& hits, RayBatch& rays) {
  const std::uint64_t returns = course.query.returns;
  HitLists lists;
  Column<std::uint64_t> totals;
  Status status = list_hits(course, returns, lists, totals);
  const std::uint64_t slots = course.query.rays.size() * returns;
  if (status) status = ask_for(course.reserve, slots * (kHitBytes + kRayBytes));
  if (!status) return status;
  rays.reserve(slots);
  for (std::size_t ray = 0; ray < course.query.rays.size(); ++ray) {
    for (std::size_t k = 0; k < returns; ++k) {
      rays.push_back(course.query.rays[ray]);
      const std::size_t at = lists.first[ray] + k;
      const bool is_hit = at < lists.first[ray + 1];
      hits.t.push_back(is_hit ? lists.hits.t[at] : kInf);
      hits.instance.push_back(is_hit ? lists.hits.instance[at] : kNone);
      hits.triangle.push_back(is_hit ? lists.hits.triangle[at] : kNone);
    }
  }
  return success();
}

/// Turns the hits of dropped rays into misses.
void drop_hits(const RayQuery& query, HitBatch& hits) {
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!RangeErrors(query.noise, i / query.returns).is_dropped()) continue;
    hits.t[i] = kInf;
    hits.instance[i] = hits.triangle[i] = kNone;
  }
}

/// Moves each hit along its ray to the measured distance.
void add_errors(const RayQuery& query, const RayBatch& rays, HitBatch& hits,
                HitDescription& about) {
  for (std::size_t begin = 0; begin < hits.size(); begin += query.returns) {
    RangeErrors errors(query.noise, begin / query.returns);
    for (std::size_t i = begin; i < begin + query.returns && hits.hit(i); ++i) {
      const Ray ray = rays[i];
      const double t = errors.measured(hits.t[i], ray.tmin);
      hits.t[i] = t;
      const Vec3d &o = ray.origin, &d = ray.direction;
      if (!about.details.empty())
        about.details[i].position = {o.x + t * d.x, o.y + t * d.y, o.z + t * d.z};
      if (!about.terms.distance.empty()) about.terms.distance[i] = distance_of(t, d);
    }
  }
}

Result<std::string> answer_closest(const RayBatchCourse& course) {
  const RayQuery& query = course.query;
  HitBatch hits;
  RayBatch rays_of_returns;
  Status status = success();
  if (query.returns > 1) {
    status = find_returns(course, hits, rays_of_returns);
  } else {
    status = ask_for(course.reserve, query.rays.size() * kHitBytes);
    if (status) {
      status = course.service.engine.closest(course.scene, query.rays, course.deadline, hits,
                                             course.options);
    }
  }
  if (!status) return status.error();
  if (query.noise.is_used()) drop_hits(query, hits);
  course.timer.add(&WorkReport::trace_us);
  HitDescription about;
  const RayBatch& rays = query.returns > 1 ? rays_of_returns : query.rays;
  status = course.describe(rays, hits, about);
  if (!status) return status.error();
  if (query.noise.is_used()) add_errors(query, rays, hits, about);
  if (course.is(AnswerLayout::kBinary)) {
    return encode_hits_binary(hits, about.details, about.terms, query.fields, course.invalid());
  }
  if (query.table) {
    return encode_hit_table(*query.table, hits, about.details, about.terms, query.fields);
  }
  if (course.is(AnswerLayout::kLines)) {
    return encode_hit_lines(hits, about.details, about.terms, query.fields, course.invalid());
  }
  std::string text = encode_hits(hits, about.details, about.terms, query.fields, query.layout);
  if (query.wants_explanation) {
    status = ask_for(course.reserve, kExplanationBytes);
    if (!status) return status.error();
    auto explained = encode_explanation(course.scene, query.rays[0], query.filter,
                                        course.options.resolved, course.deadline, course.reserve);
    if (!explained) return explained;
    if (!hits.hit(0)) {
      std::optional<NearestMiss> miss;
      status = nearest_miss(course.service.engine, course.scene, query.rays[0], course.options,
                            course.deadline, miss);
      if (!status) return status.error();
      add_member(*explained, "nearest_miss", encode_nearest_miss(course.scene, miss));
    }
    add_member(text, "explain", *explained);
  }
  return text;
}

Result<std::string> answer_any(const RayBatchCourse& course) {
  Column<std::uint8_t> occluded;
  Status status = ask_for(course.reserve, course.query.rays.size() * (1 + kNumberBytes));
  if (status) {
    status = course.service.engine.any(course.scene, course.query.rays, course.deadline, occluded,
                                       course.options);
  }
  if (!status) return status.error();
  course.timer.add(&WorkReport::trace_us);
  if (course.is(AnswerLayout::kBinary)) return encode_occlusion_binary(occluded, course.invalid());
  return course.is(AnswerLayout::kLines) ? encode_occlusion_lines(occluded, course.invalid())
                                         : encode_occlusion(occluded);
}

Result<std::string> answer_all(const RayBatchCourse& course) {
  const RayQuery& query = course.query;
  HitLists lists;
  Column<std::uint64_t> totals;
  Status status = list_hits(course, query.max_hits, lists, totals);
  if (!status) return status.error();
  course.timer.add(&WorkReport::trace_us);
  HitDescription about;
  const bool needs_rays = query.normalize || query.fields.has(HitField::kDistance) ||
                          query.fields.has_any_of(kDetailFields) ||
                          query.fields.has_any_of(kCostFields);
  if (needs_rays) status = ask_for(course.reserve, lists.hits.size() * kRayBytes);
  if (!status) return status.error();
  status =
      course.describe(needs_rays ? rays_of_hits(query.rays, lists) : RayBatch(), lists.hits, about);
  if (!status) return status.error();
  if (course.is(AnswerLayout::kBinary)) {
    return encode_hit_lists_binary(lists, totals, about.details, about.terms, query.fields,
                                   course.invalid());
  }
  return course.is(AnswerLayout::kLines)
             ? encode_hit_list_lines(lists, totals, about.details, about.terms, query.fields,
                                     course.invalid())
             : encode_hit_lists(lists, totals, about.details, about.terms, query.fields,
                                query.layout);
}

Result<std::string> answer_count(const RayBatchCourse& course) {
  Column<std::uint64_t> totals;
  Status status = ask_for(course.reserve, course.query.rays.size() * (8 + kNumberBytes));
  if (status) {
    status = course.service.engine.count(course.scene, course.query.rays, course.query.crossings,
                                         course.deadline, totals, course.options);
  }
  if (!status) return status.error();
  course.timer.add(&WorkReport::trace_us);
  if (course.is(AnswerLayout::kBinary)) return encode_counts_binary(totals, course.invalid());
  return course.is(AnswerLayout::kLines) ? encode_count_lines(totals, course.invalid())
                                         : encode_counts(totals);
}

}  // namespace

RayJsonRules rules_of(RayQuestionKind kind, const ServiceLimits& limits) {
  RayJsonRules rules;
  rules.max_rays = limits.rays;
  rules.max_hits = limits.hits;
  rules.has_fields = kind == RayQuestionKind::kClosest || kind == RayQuestionKind::kAll;
  rules.has_crossings = kind == RayQuestionKind::kAll || kind == RayQuestionKind::kCount;
  rules.has_max_hits = kind == RayQuestionKind::kAll;
  rules.has_explain = kind == RayQuestionKind::kClosest;
  rules.has_image = kind == RayQuestionKind::kClosest;
  rules.has_returns = kind == RayQuestionKind::kClosest;
  rules.has_alpha = true;
  return rules;
}

Result<std::string> answer_rays(RayQuestionKind kind, const Service& service, const Scene& scene,
                                const RayQuery& query, const RayOptions& options,
                                const Deadline& deadline, WorkTimer& timer) {
  const RayBatchCourse course{service, scene, query, options, deadline, options.reserve, timer};
  switch (kind) {
    case RayQuestionKind::kClosest:
      return query.image ? answer_image(service, scene, query, options, deadline, timer)
                         : answer_closest(course);
    case RayQuestionKind::kAny:
      return answer_any(course);
    case RayQuestionKind::kAll:
      return answer_all(course);
    case RayQuestionKind::kCount:
      return answer_count(course);
  }
  return Error{ErrorKind::kInternal, "INTERNAL", "no such question", ""};
}

}  // namespace sightline
