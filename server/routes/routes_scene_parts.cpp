#include <algorithm>
#include <array>
#include <span>

#include "proto/binary/ray_binary.h"
#include "server/http/body_reader.h"
#include "server/http/query_parameters.h"
#include "server/routes/routes.h"
#include "server/routes/scene_admission.h"
#include "server/service/answer_memory.h"
#include "server/service/node_search.h"
#include "server/service/scene_geometry.h"
#include "server/service/scene_parts.h"
#include "server/service/tree_json.h"

namespace sightline {
namespace {

/// Reads "path,extras". False after it has answered 422 QUERY_INVALID.
bool read_with(Exchange& exchange, std::string_view list, NodeQuery& query) {
  while (!list.empty()) {
    const std::string_view name = list.substr(0, list.find(','));
    list.remove_prefix(std::min(name.size() + 1, list.size()));
    if (name == "path") {
      query.with_path = true;
    } else if (name == "materials") {
      query.with_materials = true;
    } else if (name == "extras") {
      query.with_extras = true;
    } else if (name == "pose") {
      query.with_pose = true;
    } else {
      exchange.reply_problem(422, "QUERY_INVALID",
                             "with is a list of path, materials, extras and pose");
      return false;
    }
  }
  return true;
}

/// False after it has answered.
bool read_node_query(Exchange& exchange, NodeQuery& query) {
  constexpr std::uint64_t kMost = 100'000, kMostNumber = 0xffffffffu;
  constexpr std::size_t kMostPattern = 4096;
  const auto parameters = QueryParameters::read(
      exchange, {"name", "path", "material", "instance", "with", "first", "limit"});
  std::uint64_t instance = 0;
  if (!parameters || !parameters->number(exchange, "first", kMostNumber, query.first) ||
      !parameters->number(exchange, "limit", kMost, query.limit) ||
      !parameters->number(exchange, "instance", kMostNumber, instance)) {
    return false;
  }
  if (parameters->text("instance")) query.instance = static_cast<std::uint32_t>(instance);
  std::optional<std::string> with;
  return parameters->decoded(exchange, "name", kMostPattern, query.name) &&
         parameters->decoded(exchange, "path", kMostPattern, query.path) &&
         parameters->decoded(exchange, "material", kMostPattern, query.material) &&
         parameters->decoded(exchange, "with", kMostPattern, with) &&
         read_with(exchange, with.value_or(""), query);
}

void nodes(Exchange& exchange, const Service& service) {
  NodeQuery query;
  if (!read_node_query(exchange, query)) return;
  const SceneSnapshot stored = admit_scene(exchange, service);
  if (!stored) return;
  const Scene& scene = *stored->scene;
  const std::uint64_t instances = scene.description().instances.size();
  if (query.instance && *query.instance >= instances) {
    return exchange.reply_problem(422, "QUERY_INVALID",
                                  "instance is " + std::to_string(*query.instance) +
                                      ", the scene has " + std::to_string(instances) +
                                      " instances, counted from 0");
  }
  if (!went_well(exchange, exchange.reserve(scene.description().nodes.size() * kNodeSearchBytes))) {
    return;
  }
  const Deadline deadline = deadline_of(exchange, service);
  DeadlineWatch watch(deadline);
  const auto page = find_nodes(scene, query, watch);
  if (!page) return exchange.reply_error(page.error());
  if (!went_well(exchange, exchange.reserve(bytes_of_nodes(scene, query, *page)))) return;
  exchange.reply_json(200, encode_nodes(scene, query, *page));
}

void triangles(Exchange& exchange, const Service& service) {
  const auto parameters = QueryParameters::read(exchange, {"ids"});
  if (!parameters) return;
  const SceneSnapshot stored = admit_scene(exchange, service);
  if (!stored) return;
  auto text = encode_triangles(*stored->scene, parameters->text("ids").value_or(""));
  if (!text) return exchange.reply_error(text.error());
  exchange.reply_json(200, std::move(*text));
}

void animations(Exchange& exchange, const Service& service) {
  const SceneSnapshot stored = admit_scene(exchange, service);
  if (!stored) return;
  const auto& poser = stored->scene->description().poser;
  if (poser == nullptr) return exchange.reply_json(200, encode_animations({}));
  if (!went_well(exchange, exchange.reserve(poser->bytes_of_call()))) return;
  const auto list = poser->animations();
  if (!list) return exchange.reply_error(list.error());
  exchange.reply_json(200, encode_animations(*list));
}

void geometry(Exchange& exchange, const Service& service) {
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30, kMostFirst = 0xffffffffu;
  const auto parameters = QueryParameters::read(exchange, {"first", "max_bytes", "eye"});
  GeometryRange range;
  std::optional<std::array<double, 3>> eye;
  if (!parameters || !parameters->number(exchange, "first", kMostFirst, range.first) ||
      !parameters->number(exchange, "max_bytes", kMostBytes, range.max_bytes) ||
      !parameters->point(exchange, "eye", eye)) {
    return;
  }
  if (eye) range.eye = Vec3d{(*eye)[0], (*eye)[1], (*eye)[2]};
  const SceneSnapshot stored = admit_scene(exchange, service);
  if (!stored) return;
  if (!went_well(exchange, exchange.reserve(bytes_of_geometry_lists(*stored->scene)))) return;
  const GeometryAnswer answer = scene_geometry(*stored->scene, range);
  if (!went_well(exchange, exchange.reserve(bytes_of_geometry(answer)))) return;
  exchange.reply(200, encode_geometry(answer), kBinaryMediaType);
  // Indices and placements are alike: half of these bytes, or less.
  exchange.response.set_header("Vary", "Accept-Encoding");
}

void trees(Exchange& exchange, const Service& service) {
  constexpr std::uint64_t kMostLevel = 1000, kLevelBoxBytes = 512;
  const auto parameters = QueryParameters::read(exchange, {"level"});
  std::uint64_t level = 0;
  if (!parameters || !parameters->number(exchange, "level", kMostLevel, level)) return;
  const SceneSnapshot stored = admit_scene(exchange, service);
  if (!stored) return;
  // A triangle takes half a microsecond. It counts double: 12 connections that repeat this for a
  // scene of 52,078 triangles took the processors from batches.
  constexpr std::uint64_t kRaysOfTriangle = 2;
  const std::uint64_t cost = kRaysOfTriangle * stored->scene->unique_triangle_count();
  if (exchange.body != nullptr && !exchange.body->may_cost(cost)) return;
  if (!parameters->text("level")) return exchange.reply_json(200, encode_trees(*stored->scene));
  if (Status status = exchange.reserve(kMostLevelBoxes * kLevelBoxBytes); !status) {
    return exchange.reply_error(status.error());
  }
  exchange.reply_json(200, encode_trees(*stored->scene, static_cast<std::uint32_t>(level)));
}

void check(Exchange& exchange, const Service& service) {
  constexpr std::uint64_t kMostRays = 100'000;
  const auto parameters = QueryParameters::read(exchange, {"rays", "seed"});
  std::uint64_t rays = 16, seed = 1;
  if (!parameters || !parameters->number(exchange, "rays", kMostRays, rays) ||
      !parameters->number(exchange, "seed", ~std::uint64_t{0}, seed)) {
    return;
  }
  const SceneSnapshot stored = admit_scene(exchange, service);
  if (!stored) return;
  // A ray and a triangle take 25 ns, a thirtieth of what an ordinary ray takes.
  constexpr std::uint64_t kTestsOfRay = 30;
  const std::uint64_t triangles = stored->scene->instanced_triangle_count();
  const std::uint64_t cost = triangles / kTestsOfRay * rays;
  if (exchange.body != nullptr && !exchange.body->may_cost(cost)) return;
  const Deadline deadline = deadline_of(exchange, service);
  // The instances to choose from, and the rays with what is found by them.
  const std::uint64_t bytes =
      stored->scene->description().instances.size() * sizeof(std::uint32_t) +
      self_check_bytes(rays) + rays * (kRayBytes + kHitBytes + sizeof(std::uint64_t));
  if (!went_well(exchange, exchange.reserve(bytes))) return;
  const auto found = self_check(service.engine, *stored->scene, rays, seed, deadline);
  if (!found) return exchange.reply_error(found.error());
  exchange.reply_json(200, encode_self_check(*found));
}

}  // namespace

void add_scene_part_routes(Router& router, const Service& service) {
  router.add("GET", "/v1/scenes/{id}/nodes", with(service, nodes), kParameters);
  router.add("GET", "/v1/scenes/{id}/triangles", with(service, triangles), kParameters);
  router.add("GET", "/v1/scenes/{id}/animations", with(service, animations));
  router.add("GET", "/v1/scenes/{id}/geometry", with(service, geometry), kParameters);
  router.add("GET", "/v1/scenes/{id}/bvh", with(service, trees), kParameters);
  router.add("GET", "/v1/scenes/{id}/selfcheck", with(service, check), kParameters);
}

}  // namespace sightline
