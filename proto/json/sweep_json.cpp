#include "proto/json/sweep_json.h"

#include <array>

#include "core/base/infinity.h"
#include "proto/json/number_rows.h"
#include "proto/json/ray_reader.h"

namespace sightline {
namespace {

constexpr std::array<std::string_view, 1> kSweepQueryKeys{"sweeps"};
constexpr std::array<std::string_view, 6> kSweepKeys{"origin", "direction", "tmin",
                                                     "tmax",   "radius",    "half"};
constexpr unsigned kWay = 3u, kRadiusKey = 16u, kHalfKey = 32u;

class SweepReader : public RayReader {
 public:
  explicit SweepReader(const SweepJsonRules& rules)
      : RayReader({.has_fields = rules.has_fields,
                   .has_rays = false,
                   .default_fields = rules.default_fields,
                   .known_fields = kContactFields,
                   .has_marks = false,
                   .has_culling = false}),
        rules_(rules) {}

  Result<SweepQuery> read_all(std::string& body) {
    Result<RayQuery> options = read(body);
    if (!options) return std::move(options).error();
    result_.options = std::move(*options);
    SweepFault fault;
    if (!check_sweeps(result_.sweeps, fault)) return error_of(fault);
    return std::move(result_);
  }

 private:
  std::span<const std::string_view> more_keys() const override { return kSweepQueryKeys; }
  unsigned known_more_keys() const override { return rules_.has_sweeps ? 1u : 0u; }

  bool read_more(std::size_t, Value value) override {
    seen_ = true;
    const JsonPointer place = JsonPointer().key("sweeps");
    return read_array(value, "an array of sweeps", place, [&](std::size_t i, Value row) {
      return read_sweep(row, i, JsonPointer(place).index(i));
    });
  }

  bool read_sweep(Value value, std::size_t i, const JsonPointer& place) {
    if (i == rules_.max_sweeps) {
      return fail(ErrorKind::kTooLarge, "SWEEPS_TOO_MANY",
                  "a request may hold " + std::to_string(rules_.max_sweeps) + " sweeps", place);
    }
    Object object;
    if (value.get_object().get(object) != simdjson::SUCCESS) {
      return wrong(value, place, "an object");
    }
    Ray ray;
    SweptSphere sphere;
    SweptBox box;
    unsigned seen = 0;
    for (auto entry : object) {
      Field field;
      if (const auto code = std::move(entry).get(field); code != simdjson::SUCCESS) {
        return check_end(code, [&] { return place; });
      }
      std::size_t which = 0;
      if (!read_key(field, kSweepKeys, 0x3fu, place, which)) return false;
      const JsonPointer part = JsonPointer(place).key(kSweepKeys[which]);
      if (!mark_seen(1u << which, seen, part)) return false;
      const auto here = [&]() -> const JsonPointer& { return part; };
      bool good = false;
      switch (which) {
        case 0:
          good = sightline::read_vector(*this, field.value(), part, ray.origin);
          break;
        case 1:
          good = sightline::read_vector(*this, field.value(), part, ray.direction);
          break;
        case 2:
          good = read_number(field.value(), ray.tmin, here);
          break;
        case 3:
          good = read_number_or_null(field.value(), kInf, ray.tmax, here);
          break;
        case 4:
          good = read_number(field.value(), sphere.radius, here);
          break;
        default:
          good = sightline::read_vector(*this, field.value(), part, box.half);
      }
      if (!good) return false;
    }
    const bool is_sphere = (seen & kRadiusKey) != 0;
    if (is_sphere && (seen & kHalfKey) != 0) {
      return invalid("KEYS_MIXED", "a sphere has a radius, a box has half extents, not both",
                     place);
    }
    if ((seen & kWay) != kWay || (seen & (kRadiusKey | kHalfKey)) == 0) {
      return invalid("KEY_MISSING", "a sweep needs an origin, a direction, and a radius or half",
                     place);
    }
    if (is_sphere) {
      result_.sweeps.push_back(ray, sphere);
    } else {
      result_.sweeps.push_back(ray, box);
    }
    return true;
  }

  bool finish_more() override {
    return seen_ || !rules_.has_sweeps || invalid("KEY_MISSING", "needs \"sweeps\"", {});
  }

  SweepJsonRules rules_;
  bool seen_ = false;
  SweepQuery result_;
};

}  // namespace

Error error_of(const SweepFault& fault) {
  JsonPointer place = JsonPointer().key("sweeps").index(fault.sweep).key(fault.part);
  if (fault.component != SweepFault::kWhole) place.index(static_cast<std::size_t>(fault.component));
  return {ErrorKind::kInvalid, fault.code, fault.message, place.text()};
}

Result<SweepQuery> decode_sweeps(std::string& body, const SweepJsonRules& rules) {
  return SweepReader(rules).read_all(body);
}

}  // namespace sightline
