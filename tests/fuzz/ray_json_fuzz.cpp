// Ray bodies of any kind: an error with a place, or rays that another parser reads alike.
// Run:  scripts/stress.sh fuzz --target ray_json_fuzz

#include <cstdint>
#include <string>

#include "proto/json/ray_json.h"
#include "tests/fuzz/body_check.h"

namespace {

using namespace sightline;
using Json = nlohmann::json;

using fuzz::find;
using fuzz::require;
using fuzz::same;
using fuzz::same_limit;

void check_columns(const Json& document, const RayBatch& rays) {
  const Json &origins = document["origins"], &directions = document["directions"];
  require(origins.size() == rays.size() * 3, "as many rays as columns have");
  require(directions.size() == rays.size() * 3, "as many rays as columns have");
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Ray ray = rays[i];
    for (int k = 0; k < 3; ++k) {
      const std::size_t at = i * 3 + static_cast<std::size_t>(k);
      require(same(origins[at], ray.origin[k]), "origins read alike");
      require(same(directions[at], ray.direction[k]), "directions read alike");
    }
    const Json *tmin = find(document, "tmin"), *tmax = find(document, "tmax");
    require(same_limit(tmin ? &(*tmin)[i] : nullptr, ray.tmin, Ray().tmin), "tmin read alike");
    require(same_limit(tmax ? &(*tmax)[i] : nullptr, ray.tmax, Ray().tmax), "tmax read alike");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string sent(reinterpret_cast<const char*>(data), size);
  std::string body = sent;
  const auto query = decode_rays(body, {.max_rays = 64, .has_fields = size % 2 == 0});
  require(body == sent, "the body is only read");
  if (!query) {
    fuzz::check_error(query.error());
    return 0;
  }
  RayFault fault;
  require(check_rays(query->rays, fault), "rays have passed the border");
  require(query->rays.size() <= 64, "limits hold");
  require(!query->fields.empty(), "there is something to answer");
  const Json document = Json::parse(sent, nullptr, false);
  require(document.is_object(), "what is accepted is JSON");
  if (query->layout == AnswerLayout::kRows) {
    fuzz::check_rows(document["rays"], query->rays);
  } else {
    check_columns(document, query->rays);
  }
  return 0;
}
