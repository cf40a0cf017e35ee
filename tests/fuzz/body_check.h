#pragma once
/// What the readers of bodies promise, held against another parser of JSON.

#include <bit>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "core/query/ray_batch.h"
#include "proto/problem.h"
#include "tests/fuzz/promise.h"

namespace sightline::fuzz {

inline void check_error(const Error& error) {
  require(!error.code.empty() && !error.message.empty(), "errors say what is wrong");
  require(error.message.size() < 1000 && error.pointer.size() < 1000,
          "errors do not echo the body");
  require(error.pointer.empty() || error.pointer.front() == '/', "places are JSON pointers");
  require(nlohmann::json::accept(encode_problem(make_problem(error, 422, "x"))),
          "problems are JSON");
}

inline bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// Bit for bit, but for the sign of "-0", which nlohmann reads as an integer.
inline bool same(const nlohmann::json& number, double value) {
  const double other = number.get<double>();
  return same_bits(other, value) || (other == 0 && value == 0 && number.is_number_integer());
}

inline bool same_limit(const nlohmann::json* limit, double value, double otherwise) {
  return limit == nullptr || limit->is_null() ? value == otherwise : same(*limit, value);
}

inline const nlohmann::json* find(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

/// Rays that came as objects.
inline void check_rows(const nlohmann::json& rows, const RayBatch& rays) {
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

inline void check_same_rays(const RayBatch& a, const RayBatch& b) {
  require(a.size() == b.size(), "as many rays");
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      require(same_bits(a[i].origin[k], b[i].origin[k]), "the same origins");
      require(same_bits(a[i].direction[k], b[i].direction[k]), "the same directions");
    }
    require(same_bits(a[i].tmin, b[i].tmin) && same_bits(a[i].tmax, b[i].tmax), "the same limits");
  }
}

}  // namespace sightline::fuzz
