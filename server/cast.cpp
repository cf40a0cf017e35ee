#include "server/cast.h"

#include "core/run/engine.h"
#include "proto/hit_json.h"
#include "server/hit_terms.h"
#include "server/scene_source.h"

namespace sightline {
namespace {

constexpr int kHit = 0, kMiss = 1, kError = 2;

int complain(std::ostream& complaints, const Error& error) {
  complaints << "sightline: " << error.code << ": " << error.message << "\n";
  return kError;
}

}  // namespace

int run_cast(const CastCommand& command, std::ostream& out, std::ostream& complaints) {
  RayBatch rays;
  rays.push_back(command.ray);
  RayFault fault;
  if (!check_rays(rays, fault)) {
    return complain(complaints, {ErrorKind::kInvalid, fault.code, fault.message, fault.part});
  }
  auto loaded = load_source(command.source, {command.scene});
  if (!loaded) return complain(complaints, loaded.error());
  auto engine = Engine::create({.threads = 1, .kernel = command.kernel});
  if (!engine) return complain(complaints, engine.error());
  const Scene& scene = *loaded->scene;

  if (command.any) {
    Column<std::uint8_t> occluded;
    if (Status status = (*engine)->any(scene, rays, Deadline::never(), occluded); !status) {
      return complain(complaints, status.error());
    }
    out << (occluded[0] != 0 ? "true" : "false") << "\n";
    return occluded[0] != 0 ? kHit : kMiss;
  }
  HitBatch hits;
  Column<HitDetail> details;
  Status status = (*engine)->closest(scene, rays, Deadline::never(), hits);
  if (status) status = (*engine)->details(scene, rays, hits, Deadline::never(), details);
  if (!status) return complain(complaints, status.error());
  const HitTerms terms = hit_terms(scene, hits, command.fields);
  out << encode_hit(hits, details, terms, command.fields, 0) << "\n";
  return hits.hit(0) ? kHit : kMiss;
}

}  // namespace sightline
