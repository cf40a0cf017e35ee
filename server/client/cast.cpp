#include "server/client/commands.h"

#include <limits>

#include "core/run/engine.h"
#include "proto/json/hit_json.h"
#include "server/operation/progress_bar.h"
#include "server/service/hit_terms.h"
#include "server/service/scene_source.h"

namespace sightline {
namespace {

constexpr int kHit = 0, kMiss = 1, kError = 2;

int complain(std::ostream& complaints, const Error& error) {
  complaints << "sightline: " << error.code << ": " << error.message << "\n";
  return kError;
}

/// Each prints its answer and says in `hit` whether there was any.
Status cast_any(const Engine& engine, const Scene& scene, const RayBatch& rays, std::ostream& out,
                bool& hit) {
  Column<std::uint8_t> occluded;
  if (Status status = engine.any(scene, rays, Deadline::never(), occluded); !status) return status;
  hit = occluded[0] != 0;
  out << (hit ? "true" : "false") << "\n";
  return success();
}

Status cast_count(const Engine& engine, const Scene& scene, const RayBatch& rays,
                  Crossings crossings, std::ostream& out, bool& hit) {
  Column<std::uint64_t> totals;
  if (Status status = engine.count(scene, rays, crossings, Deadline::never(), totals); !status) {
    return status;
  }
  hit = totals[0] != 0;
  out << totals[0] << "\n";
  return success();
}

Status cast_all(const Engine& engine, const Scene& scene, const RayBatch& rays,
                const CastCommand& command, std::ostream& out, bool& hit) {
  constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();
  HitLists lists;
  Column<std::uint64_t> totals;
  HitDescription description;
  Status status = engine.all(scene, rays, {command.crossings, kNoLimit, kNoLimit},
                             Deadline::never(), lists, totals);
  if (status) {
    status = describe_hits(engine, {scene, rays_of_hits(rays, lists), lists.hits, command.fields},
                           Deadline::never(), description);
  }
  if (!status) return status;
  for (std::size_t i = 0; i < lists.hits.size(); ++i) {
    out << encode_hit(lists.hits, description.details, description.terms, command.fields, i)
        << "\n";
  }
  hit = lists.hits.size() > 0;
  return success();
}

Status cast_closest(const Engine& engine, const Scene& scene, const RayBatch& rays, FieldSet fields,
                    std::ostream& out, bool& hit) {
  HitBatch hits;
  HitDescription description;
  Status status = engine.closest(scene, rays, Deadline::never(), hits);
  if (status) {
    status = describe_hits(engine, {scene, rays, hits, fields}, Deadline::never(), description);
  }
  if (!status) return status;
  out << encode_hit(hits, description.details, description.terms, fields, 0) << "\n";
  hit = hits.hit(0);
  return success();
}

Status cast(const Engine& engine, const Scene& scene, const RayBatch& rays,
            const CastCommand& command, std::ostream& out, bool& hit) {
  switch (command.mode) {
    case CastMode::kClosest:
      return cast_closest(engine, scene, rays, command.fields, out, hit);
    case CastMode::kAny:
      return cast_any(engine, scene, rays, out, hit);
    case CastMode::kAll:
      return cast_all(engine, scene, rays, command, out, hit);
    case CastMode::kCount:
      return cast_count(engine, scene, rays, command.crossings, out, hit);
  }
  return success();
}

}  // namespace

int run_cast(const CastCommand& command, std::ostream& out, std::ostream& complaints) {
  RayBatch rays;
  rays.push_back(command.ray);
  RayFault fault;
  if (!check_rays(rays, fault)) {
    return complain(complaints, {ErrorKind::kInvalid, fault.code,
                                 "--" + std::string(fault.part) + ": " + fault.message, ""});
  }
  Progress progress;
  auto loaded = [&] {
    const ProgressBar bar([&] { return progress_line(progress.reading()); });
    return load_source(command.source, {command.scene}, progress, Laziness::kWhenNeeded,
                       command.fields.has_any_of(kAttributeFields));
  }();
  if (!loaded) return complain(complaints, loaded.error());
  auto engine = Engine::create({.threads = 1, .kernel = command.kernel});
  if (!engine) return complain(complaints, engine.error());

  bool hit = false;
  if (Status status = cast(**engine, *loaded->scene, rays, command, out, hit); !status) {
    return complain(complaints, status.error());
  }
  return hit ? kHit : kMiss;
}

}  // namespace sightline
