// Ray bodies of any kind: an error with a place, or rays that another parser reads alike.
// Run:  scripts/stress.sh fuzz --target ray_json_fuzz

#include <bit>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "proto/problem.h"
#include "proto/ray_json.h"

namespace {

using namespace sightline;
using Json = nlohmann::json;

void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

/// Bit for bit, but for the sign of "-0", which nlohmann reads as an integer.
bool same(const Json& number, double value) {
  const double other = number.get<double>();
  return std::bit_cast<std::uint64_t>(other) == std::bit_cast<std::uint64_t>(value) ||
         (other == 0 && value == 0 && number.is_number_integer());
}

bool same_limit(const Json* limit, double value, double otherwise) {
  return limit == nullptr || limit->is_null() ? value == otherwise : same(*limit, value);
}

const Json* find(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

void check_rows(const Json& rows, const RayBatch& rays) {
  require(rows.size() == rays.size(), "as many rays as rows");
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Ray ray = rays[i];
    for (int k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(k);
      require(same(rows[i]["origin"][at], ray.origin[k]), "origins read alike");
      require(same(rows[i]["direction"][at], ray.direction[k]), "directions read alike");
    }
    require(same_limit(find(rows[i], "tmin"), ray.tmin, Ray().tmin), "tmin read alike");
    require(same_limit(find(rows[i], "tmax"), ray.tmax, Ray().tmax), "tmax read alike");
  }
}

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
    const Error& error = query.error();
    require(!error.code.empty() && !error.message.empty(), "errors say what is wrong");
    require(error.message.size() < 1000 && error.pointer.size() < 1000,
            "errors do not echo the body");
    require(error.pointer.empty() || error.pointer.front() == '/', "places are JSON pointers");
    require(Json::accept(encode_problem(make_problem(error, 422, "x"))), "problems are JSON");
    return 0;
  }
  RayFault fault;
  require(check_rays(query->rays, fault), "rays have passed the border");
  require(query->rays.size() <= 64, "limits hold");
  require(!query->fields.empty(), "there is something to answer");
  const Json document = Json::parse(sent, nullptr, false);
  require(document.is_object(), "what is accepted is JSON");
  if (query->layout == AnswerLayout::kRows) {
    check_rows(document["rays"], query->rays);
  } else {
    check_columns(document, query->rays);
  }
  return 0;
}
