#include <algorithm>

#include "proto/binary/point_binary.h"
#include "proto/json/visibility_json.h"
#include "server/routes/ray_request.h"
#include "server/routes/routes.h"
#include "server/service/answer_memory.h"
#include "server/service/hit_terms.h"

namespace sightline {
namespace {

void visible(Exchange& exchange, const Service& service) {
  RayRequest request(exchange, service);
  VisibilityQuery query;
  if (!request.read_json(
          [&](std::string& body, QueryOptions& options) -> Status {
            auto decoded = decode_visibility(body, service.limits.rays);
            if (!decoded) return decoded.error();
            query = std::move(*decoded);
            options = query.options;
            exchange.rays = query.pairs.size();
            return success();
          },
          RayRequest::Tables::kColumns)) {
    return;
  }
  if (request.is_binary() && query.first_blocker) {
    return exchange.reply_error({ErrorKind::kInvalid, "BLOCKERS_ARE_TEXT",
                                 "blockers come as JSON alone", "/first_blocker"});
  }
  Column<std::uint8_t> visible;
  HitBatch hits;
  HitBatch* blockers = query.first_blocker ? &hits : nullptr;
  // Two bytes for each pair, and of blockers the hit and its ray.
  const std::uint64_t pairs = query.pairs.size();
  const std::uint64_t pair_bytes = 2 + (blockers != nullptr ? kHitBytes + kRayBytes : 0);
  const std::uint64_t at_once = std::min<std::uint64_t>(pairs, Engine::kRaysAtOnce);
  if (!request.reserve(pairs * pair_bytes + at_once * (kRayBytes + kHitBytes)) ||
      !request.went_well(service.engine.visibility(request.scene(), query.pairs, request.deadline(),
                                                   visible, blockers, request.options()))) {
    return;
  }
  request.add_time(&WorkReport::trace_us);
  if (request.is_binary()) return request.reply(encode_visibility_binary(query.pairs, visible));
  HitDescription about;
  if (blockers != nullptr) {
    RayBatch rays;
    rays.reserve(hits.size());
    for (std::size_t i = 0; i < hits.size(); ++i) rays.push_back(query.pairs.ray(i));
    if (!request.describe(rays, hits, about)) return;
  }
  request.reply(encode_visibility(query, visible, blockers, about.details, about.terms));
}

}  // namespace

void add_visibility_routes(Router& router, const Service& service) {
  router.add("POST", "/v1/scenes/{id}/visibility", with(service, visible));
}

}  // namespace sightline
