#include "proto/ray_binary.h"
#include "proto/ray_columns.h"
#include "server/http/media_type.h"
#include "server/http/request_body.h"
#include "server/routes/ray_request.h"
#include "server/routes/routes.h"
#include "server/service/answer_memory.h"

namespace sightline {
namespace {

void ask_rays(Exchange& exchange, const Service& service, RayQuestionKind kind) {
  RayRequest request(exchange, service);
  if (request.streamed(kind) || !request.read(rules_of(kind, service.limits))) return;
  auto answer = answer_rays(kind, service, request.scene(), request.query(), request.options(),
                            request.deadline(), exchange.memory, request.timer());
  if (!answer) return exchange.reply_error(answer.error());
  request.reply(std::move(*answer));
}

/// No scene: the rays themselves.
void generate(Exchange& exchange, const Service& service) {
  std::string body;
  if (!admit_query_type(exchange) || !admit_body(exchange, service.limits.query_bytes) ||
      !read_body(exchange, service.limits.query_bytes, kRayJsonPadding, body)) {
    return;
  }
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

void add_ray_routes(Router& router, const Service& service) {
  router.add("POST", "/v1/rays:generate",
             [&service](Exchange& exchange) { generate(exchange, service); });
  router.add("POST", "/v1/scenes/{id}/rays:closest", [&service](Exchange& exchange) {
    ask_rays(exchange, service, RayQuestionKind::kClosest);
  });
  router.add("POST", "/v1/scenes/{id}/rays:any", [&service](Exchange& exchange) {
    ask_rays(exchange, service, RayQuestionKind::kAny);
  });
  router.add("POST", "/v1/scenes/{id}/rays:all", [&service](Exchange& exchange) {
    ask_rays(exchange, service, RayQuestionKind::kAll);
  });
  router.add("POST", "/v1/scenes/{id}/rays:count", [&service](Exchange& exchange) {
    ask_rays(exchange, service, RayQuestionKind::kCount);
  });
}

}  // namespace sightline
