#include "server/client/commands.h"

#include <limits>

#include "core/run/engine.h"
#include "core/run/unmatched_names.h"
#include "proto/json/hit_lines.h"
#include "proto/json/ray_lines.h"
#include "server/client/ray_question.h"
#include "server/operation/progress_bar.h"
#include "server/service/hit_terms.h"
#include "server/service/scene_source.h"

namespace sightline {
namespace {

Result<std::string> cast_any(const Engine& engine, const Scene& scene, const RayQuery& query) {
  Column<std::uint8_t> occluded;
  Status status = engine.any(scene, query.rays, Deadline::never(), occluded);
  if (!status) return status.error();
  return encode_occlusion_lines(occluded, nullptr);
}

Result<std::string> cast_count(const Engine& engine, const Scene& scene, const RayQuery& query) {
  Column<std::uint64_t> totals;
  Status status = engine.count(scene, query.rays, query.crossings, Deadline::never(), totals);
  if (!status) return status.error();
  return encode_count_lines(totals, nullptr);
}

Result<std::string> cast_all(const Engine& engine, const Scene& scene, const RayQuery& query) {
  constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();
  HitLists lists;
  Column<std::uint64_t> totals;
  HitDescription description;
  Status status = engine.all(scene, query.rays, {query.crossings, kNoLimit, kNoLimit},
                             Deadline::never(), lists, totals);
  if (status) {
    status = describe_hits(engine,
                           {.scene = scene,
                            .rays = rays_of_hits(query.rays, lists),
                            .hits = lists.hits,
                            .fields = query.fields,
                            .named = query.named_fields},
                           Deadline::never(), description);
  }
  if (!status) return status.error();
  return encode_hit_list_lines(lists, totals, description.details, description.terms, query.fields,
                               nullptr);
}

Result<std::string> cast_closest(const Engine& engine, const Scene& scene, const RayQuery& query) {
  HitBatch hits;
  HitDescription description;
  Status status = engine.closest(scene, query.rays, Deadline::never(), hits);
  if (status) {
    status = describe_hits(engine,
                           {.scene = scene,
                            .rays = query.rays,
                            .hits = hits,
                            .fields = query.fields,
                            .named = query.named_fields},
                           Deadline::never(), description);
  }
  if (!status) return status.error();
  return encode_hit_lines(hits, description.details, description.terms, query.fields, nullptr);
}

Result<std::string> cast(const Engine& engine, const Scene& scene, CastMode mode,
                         const std::string& lines) {
  RayJsonRules rules;
  rules.has_crossings = mode == CastMode::kAll || mode == CastMode::kCount;
  std::string text = lines;
  const auto query = RayLines(rules).decode(text);
  if (!query) return query.error();
  if (Status known =
          tell_unknown_fields(scene.description(), query->named_fields, Deadline::never(), nullptr);
      !known) {
    return std::move(known).error();
  }
  switch (mode) {
    case CastMode::kAny:
      return cast_any(engine, scene, *query);
    case CastMode::kAll:
      return cast_all(engine, scene, *query);
    case CastMode::kCount:
      return cast_count(engine, scene, *query);
    case CastMode::kClosest:
      break;
  }
  return cast_closest(engine, scene, *query);
}

/// Checks the ray of the command line, so that errors name its flags.
Status check_flags(const CastCommand& command) {
  RayBatch rays;
  if (command.rays.empty()) rays.push_back(command.ray);
  RayFault fault;
  if (check_rays(rays, fault)) return success();
  return Error{ErrorKind::kInvalid, fault.code,
               "--" + std::string(fault.part) + ": " + fault.message, ""};
}

}  // namespace

int run_cast(const CastCommand& command, std::istream& in, std::ostream& out,
             std::ostream& complaints) {
  if (Status status = check_flags(command); !status) return complain(complaints, status.error());
  const FieldSet fields = command.fields.value_or(kDefaultHitFields);
  Progress progress;
  auto loaded = [&] {
    const ProgressBar bar([&] { return progress_line(progress.reading()); });
    return load_source(command.source, {command.scene}, progress, Laziness::kWhenNeeded,
                       fields.has_any_of(kAttributeFields));
  }();
  if (!loaded) return complain(complaints, loaded.error());
  auto engine = Engine::create({.threads = 1, .kernel = command.kernel});
  if (!engine) return complain(complaints, engine.error());
  const auto answer = [&](const std::string& lines, std::size_t) {
    return cast(**engine, *loaded->scene, command.mode, lines);
  };
  return ask_rays(command, answer, in, out, complaints);
}

}  // namespace sightline
