#include "tests/bench/embree_server.h"

#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "server/http/body_reader.h"
#include "server/http/http_server.h"
#include "tests/bench/embree_scene.h"

namespace sightline::bench {
namespace {

using Json = nlohmann::json;

struct FloatHit {
  bool hit = false;
  float t = 0;
  TriangleId id{};
};

FloatHit trace(const EmbreeScene& embree, const float* origin, const float* direction) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray{};
  ray.ray.org_x = origin[0];
  ray.ray.org_y = origin[1];
  ray.ray.org_z = origin[2];
  ray.ray.dir_x = direction[0];
  ray.ray.dir_y = direction[1];
  ray.ray.dir_z = direction[2];
  ray.ray.tfar = std::numeric_limits<float>::infinity();
  ray.ray.mask = ~0u;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(embree.top(), &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {true,
          ray.ray.tfar,
          {EmbreeScene::instance_of(ray.hit.geomID, ray.hit.instID[0]), ray.hit.primID}};
}

class Answerer {
 public:
  explicit Answerer(const Scene& scene) : scene_(scene), embree_(scene, {}) {}

  std::string answer(const std::string& body) const {
    const Json document = Json::parse(body);
    return (document.contains("rays") ? rows(document["rays"]) : columns(document)).dump();
  }

 private:
  Json rows(const Json& rays) const {
    Json hits = Json::array();
    for (const Json& ray : rays) {
      const auto origin = ray["origin"].get<std::vector<float>>();
      const auto direction = ray["direction"].get<std::vector<float>>();
      const FloatHit hit = trace(embree_, origin.data(), direction.data());
      if (!hit.hit) {
        hits.push_back(nullptr);
        continue;
      }
      const auto [primitive, triangle] = in_file(hit.id);
      hits.push_back({{"t", hit.t},
                      {"instance", hit.id.instance},
                      {"primitive", primitive},
                      {"triangle", triangle}});
    }
    return {{"hits", std::move(hits)}};
  }
  Json columns(const Json& document) const {
    const auto origins = document["origins"].get<std::vector<float>>();
    const auto directions = document["directions"].get<std::vector<float>>();
    Json t = Json::array(), instances = Json::array(), primitives = Json::array(),
         triangles = Json::array();
    for (std::size_t i = 0; i < origins.size(); i += 3) {
      const FloatHit hit = trace(embree_, &origins[i], &directions[i]);
      if (!hit.hit) {
        t.push_back(nullptr);
        instances.push_back(-1);
        primitives.push_back(-1);
        triangles.push_back(-1);
        continue;
      }
      const auto [primitive, triangle] = in_file(hit.id);
      t.push_back(hit.t);
      instances.push_back(hit.id.instance);
      primitives.push_back(primitive);
      triangles.push_back(triangle);
    }
    return {{"t", std::move(t)},
            {"instance", std::move(instances)},
            {"primitive", std::move(primitives)},
            {"triangle", std::move(triangles)}};
  }
  /// Primitive, and triangle within it.
  std::pair<std::uint32_t, std::uint32_t> in_file(const TriangleId& id) const {
    const Mesh& mesh =
        *scene_.description().meshes[scene_.description().instances[id.instance].mesh];
    const Primitive& part = mesh.primitives[scene_.primitive_of(id)];
    return {part.file_primitive, id.triangle - part.first_triangle};
  }

  const Scene& scene_;
  const EmbreeScene embree_;
};

}  // namespace

void serve_embree(const Scene& scene, int workers, int port) {
  const Answerer answerer(scene);
  HttpLimits limits;
  limits.workers = static_cast<std::size_t>(workers);
  HttpServer server(
      limits,
      [&](Exchange& exchange) {
        std::string body;
        if (exchange.body != nullptr) {
          constexpr std::uint64_t kBytesPerRay = 64;
          BodyReader& reader = *exchange.body;
          // As Sightline: a whole body, and many rays on a worker for long requests.
          if (!reader.ask_for(std::numeric_limits<std::uint64_t>::max()) ||
              !reader.may_cost(reader.unread_bytes().value_or(0) / kBytesPerRay)) {
            return;
          }
          reader.read_all(body, [](std::size_t) { return true; });
        }
        exchange.reply_json(200, answerer.answer(body));
      },
      [](const std::string&, const std::string&) {});
  if (!server.bind({"127.0.0.1", port})) return;
  server.serve();
}

}  // namespace sightline::bench
