#include "proto/binary/ray_binary.h"
#include "proto/json/ray_columns.h"
#include "server/http/media_type.h"
#include "server/http/request_body.h"
#include "server/http/request_memory.h"
#include "server/routes/ray_request.h"
#include "server/routes/routes.h"
#include "server/routes/scene_admission.h"
#include "server/service/answer_memory.h"

namespace sightline {
namespace {

void ask_rays(Exchange& exchange, const Service& service, const Journal& journal,
              RayQuestionKind kind) {
  RayRequest request(exchange, service);
  const auto tables =
      kind == RayQuestionKind::kClosest ? RayRequest::Tables::kHits : RayRequest::Tables::kColumns;
  if (request.streamed(kind, journal) || !request.read(rules_of(kind, service.limits), tables))
    return;
  auto answer = answer_rays(kind, service, request.scene(), request.query(), request.options(),
                            request.deadline(), request.timer());
  if (!answer) return exchange.reply_error(answer.error());
  request.reply(std::move(*answer));
}

/// No scene: the rays themselves.
void generate(Exchange& exchange, const Service& service) {
  std::string body;
  if (!read_query_body(exchange, service, body)) return;
  const bool is_binary = exchange.wants(kBinaryMediaType);
  const std::uint64_t encoded_bytes = is_binary ? kRayBytes : 8 * kNumberBytes;
  const auto query =
      decode_rays(body, {.max_rays = service.limits.rays,
                         .has_fields = false,
                         .has_scene = false,
                         .admit_made = [&](std::uint64_t rays) {
                           return exchange.reserve(rays * (kRayBytes + encoded_bytes));
                         }});
  if (!query) return exchange.reply_error(query.error());
  exchange.rays = query->rays.size();
  if (is_binary) {
    return exchange.reply(200, encode_rays_binary(query->rays), kBinaryMediaType);
  }
  exchange.reply_json(200, encode_ray_columns(query->rays));
}

}  // namespace

void add_ray_routes(Router& router, const Service& service, const Journal& journal) {
  router.add("POST", "/v1/rays:generate", with(service, generate));
  const auto ask = [&](RayQuestionKind kind) {
    return [&service, journal, kind](Exchange& exchange) {
      ask_rays(exchange, service, journal, kind);
    };
  };
  router.add("POST", "/v1/scenes/{id}/rays:closest", ask(RayQuestionKind::kClosest));
  router.add("POST", "/v1/scenes/{id}/rays:any", ask(RayQuestionKind::kAny));
  router.add("POST", "/v1/scenes/{id}/rays:all", ask(RayQuestionKind::kAll));
  router.add("POST", "/v1/scenes/{id}/rays:count", ask(RayQuestionKind::kCount));
}

}  // namespace sightline
