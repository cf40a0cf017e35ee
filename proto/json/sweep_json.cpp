#include "proto/json/sweep_json.h"

#include <array>

#include "core/base/infinity.h"
#include "core/query/box_batch.h"
#include "proto/json/number_rows.h"
#include "proto/json/ray_reader.h"

namespace sightline {
namespace {

constexpr std::array<std::string_view, 1> kSweepQueryKeys{"sweeps"};
constexpr std::array<std::string_view, 10> kSweepKeys{
    "origin", "direction", "tmin", "tmax", "radius", "half", "from", "to", "rotation", "axes"};

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
    Result<QueryOptions> options = read_options(body);
    if (!options) return std::move(options).error();
    result_.options = std::move(*options);
    SweepFault fault;
    if (!check_sweeps(result_.sweeps, fault)) return error_of(fault);
    return std::move(result_);
  }

 private:
  /// Bits of kSweepKeys.
  static constexpr unsigned kOrigin = 1u, kDirection = 2u, kRadius = 16u, kHalf = 32u, kFrom = 64u,
                            kTo = 128u, kRotation = 256u, kAxes = 512u;
  static constexpr unsigned kTurn = kRotation | kAxes;

  std::span<const std::string_view> more_keys() const override {
    static_assert(kSweepQueryKeys.size() <= kMostMoreKeys);
    return kSweepQueryKeys;
  }
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
    Row row;
    unsigned seen = 0;
    const auto take = [&](std::size_t which, Value part, const JsonPointer& part_place) {
      return read_part(part, which, part_place, row);
    };
    if (!read_members(value, kSweepKeys, 0x3ffu, place, seen, take)) return false;
    return append(row, seen, place);
  }

  struct Row {
    Ray ray;
    double radius = 0;
    Vec3d half, from, to;
    std::array<double, 4> rotation{};
    std::array<Vec3d, 3> axes;
  };

  bool read_part(Value value, std::size_t which, const JsonPointer& part, Row& row) {
    const auto here = [&]() -> const JsonPointer& { return part; };
    switch (which) {
      case 0:
        return sightline::read_vector(*this, value, part, row.ray.origin);
      case 1:
        return sightline::read_vector(*this, value, part, row.ray.direction);
      case 2:
        return read_number(value, row.ray.tmin, here);
      case 3:
        return read_number_or_null(value, kInf, row.ray.tmax, here);
      case 4:
        return read_number(value, row.radius, here);
      case 5:
        return sightline::read_vector(*this, value, part, row.half);
      case 6:
        return sightline::read_vector(*this, value, part, row.from);
      case 7:
        return sightline::read_vector(*this, value, part, row.to);
      case 8:
        return read_numbers(*this, value, part, row.rotation.data(), 4);
      default:
        return read_axes(*this, value, part, row.axes);
    }
  }

  /// The sweep that a row describes, by the keys that it has.
  bool append(Row& row, unsigned seen, const JsonPointer& place) {
    const unsigned shape = seen & (kRadius | kHalf | kFrom | kTo | kTurn);
    if ((shape & kRadius) != 0 && (shape & (kHalf | kTurn)) != 0) {
      return invalid("KEYS_MIXED",
                     "a sphere or capsule has a radius, a box has half extents, not both", place);
    }
    if ((shape & (kFrom | kTo)) != 0) {
      if ((seen & kOrigin) != 0 || (shape & (kHalf | kTurn)) != 0) {
        return invalid("KEYS_MIXED", "a capsule has two ends, from and to, and a radius, no origin",
                       place);
      }
      if (shape != (kFrom | kTo | kRadius) || (seen & kDirection) == 0) {
        return invalid("KEY_MISSING", "a capsule needs from, to, a direction and a radius", place);
      }
      row.ray.origin = row.from;
      result_.sweeps.push_back(row.ray, SweptCapsule{row.to, row.radius});
      return true;
    }
    if ((seen & (kOrigin | kDirection)) != (kOrigin | kDirection) ||
        (shape & (kRadius | kHalf)) == 0) {
      return invalid("KEY_MISSING", "a sweep needs an origin, a direction, and a radius or half",
                     place);
    }
    if (shape == kRadius) {
      result_.sweeps.push_back_sphere(row.ray, row.radius);
      return true;
    }
    SweptBox box{row.half};
    if ((shape & kTurn) == kTurn) {
      return invalid("KEYS_MIXED", "a box has a rotation or axes, not both", place);
    }
    if ((shape & kAxes) != 0) box.axes = row.axes;
    if ((shape & kRotation) != 0) {
      const auto& q = row.rotation;
      if (!is_rotation(q[0], q[1], q[2], q[3])) {
        return invalid("BOX_ROTATION_NOT_UNIT", kRotationNotUnit,
                       JsonPointer(place).key("rotation"));
      }
      box.axes = rotated_axes(q[0], q[1], q[2], q[3]);
    }
    result_.sweeps.push_back(row.ray, box);
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
