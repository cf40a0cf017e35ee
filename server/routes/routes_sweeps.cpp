#include "proto/binary/hit_binary.h"
#include "proto/json/sweep_json.h"
#include "server/routes/ray_request.h"
#include "server/routes/routes.h"
#include "server/service/answer_memory.h"
#include "server/service/hit_terms.h"

namespace sightline {
namespace {

/// A ray, the size of the shape, its kind, and the axes of a box.
constexpr std::uint64_t kSweepBytes = kRayBytes + 4 * sizeof(Vec3d) + 1 + sizeof(std::uint32_t);

void first_contacts(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  SweepQuery query;
  if (!request.read_sweeps({}, query)) return;
  const SweepBatch& sweeps = query.sweeps;
  HitBatch hits;
  if (!request.reserve(sweeps.count() * (kSweepBytes + kHitBytes)) ||
      !request.went_well(service.engine.sweep(request.scene(), sweeps, false, request.deadline(),
                                              hits, request.options()))) {
    return;
  }
  request.add_time(&WorkReport::trace_us);
  const FieldSet fields = request.query().fields;
  HitDescription about;
  if (!request.reserve(bytes_of_description(hits.size(), fields))) return;
  if (fields.has_any_of({HitField::kPosition, HitField::kNormal}) &&
      !request.went_well(service.engine.sweep_details(request.scene(), sweeps, hits,
                                                      request.deadline(), about.details))) {
    return;
  }
  about.terms = hit_terms(request.scene(), hits, fields);
  if (fields.has(HitField::kDistance)) {
    for (std::size_t i = 0; i < hits.size(); ++i)
      about.terms.distance.push_back(distance_of(hits.t[i], sweeps.rays[i].direction));
  }
  request.add_time(&WorkReport::describe_us);
  if (!request.reserve(bytes_of_encoded(hits.size(), fields, about.terms))) return;
  request.reply_hits(hits, about);
}

void any_contacts(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  SweepQuery query;
  if (!request.read_sweeps({.has_fields = false}, query)) return;
  HitBatch hits;
  if (!request.reserve(query.sweeps.count() * (kSweepBytes + kHitBytes + kNumberBytes)) ||
      !request.went_well(service.engine.sweep(request.scene(), query.sweeps, true,
                                              request.deadline(), hits, request.options()))) {
    return;
  }
  Column<std::uint8_t> met(hits.size());
  for (std::size_t i = 0; i < hits.size(); ++i) met[i] = hits.hit(i) ? 1 : 0;
  request.add_time(&WorkReport::trace_us);
  request.reply(request.is_binary() ? encode_occlusion_binary(met, nullptr)
                                    : encode_occlusion(met));
}

}  // namespace

void add_sweep_routes(Router& router, const Service& service) {
  router.add("POST", "/v1/scenes/{id}/sweeps:closest", with(service, first_contacts));
  router.add("POST", "/v1/scenes/{id}/sweeps:any", with(service, any_contacts));
}

}  // namespace sightline
