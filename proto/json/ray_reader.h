#pragma once
/// RayReader: reads rays from JSON bodies that may also have other members. For files of this room
/// only.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/json/json_reader.h"
#include "proto/json/ray_json.h"

namespace sightline {

/// Value of `component` or `element` for a vector or a column as a whole.
inline constexpr std::size_t kWholeTuple = static_cast<std::size_t>(-1);

/// The parts of a ray, with their keys in rows and in columns.
enum class RayPart { kOrigin, kDirection, kTmin, kTmax, kMask };
inline constexpr std::array<std::string_view, 5> kRayRowKeys{"origin", "direction", "tmin", "tmax",
                                                             "mask"};
inline constexpr std::array<std::string_view, 4> kRayColumnKeys{"origins", "directions", "tmin",
                                                                "tmax"};
inline constexpr std::array<std::string_view, 1> kRayMoreKeys{"filters"};

/// Reads one body of rays: construct, read() once. Derived classes add members. Functions that
/// return false have set error().
class RayReader : protected JsonReader {
 public:
  explicit RayReader(const RayJsonRules& rules) : rules_(rules) {
    query_.fields = rules.default_fields;
  }
  virtual ~RayReader() = default;
  RayReader(const RayReader&) = delete;
  RayReader& operator=(const RayReader&) = delete;

  /// Reads the body, as decode_rays does.
  Result<RayQuery> read(std::string& body);
  /// Reads a body without rays. Its other members are read by the derived class.
  Result<QueryOptions> read_options(std::string& body);

 protected:
  /// The most keys of a body: a bit set holds all of them. And the most of more_keys().
  static constexpr std::size_t kMostKeys = 32, kMostMoreKeys = 8;
  /// Keys after those of rays. A derived class has its own.
  virtual std::span<const std::string_view> more_keys() const {
    return std::span(kRayMoreKeys).first(rules_.has_filters ? 1 : 0);
  }
  /// A bit set of those of more_keys() that are allowed.
  virtual unsigned known_more_keys() const { return (1u << more_keys().size()) - 1; }
  /// Reads the value of more_keys()[which].
  virtual bool read_more(std::size_t which, Value value) {
    static_cast<void>(which);
    return read_filters(value);
  }
  /// Reads a ray as an object, and appends it. `ray` is its number, for pointers.
  bool read_row(Value value, std::size_t ray);
  /// Appends a ray. The column of masks is made when the first row has a mask.
  void push_row(const Ray& row, std::uint32_t mask);
  /// Checks all rays by check_rays, unless invalid ones are to be marked.
  bool check_limits_and_directions();
  static JsonPointer ray_place(std::size_t ray) { return JsonPointer().key("rays").index(ray); }
  /// Reads a choice of triangles at `place`: {"nodes":..,"names":..,"materials":..}. If `without`
  /// is not null, the choice may have a member "exclude", which is read into it; its other members
  /// are then optional.
  bool read_choice(const JsonPointer& place, Value value, std::optional<TriangleChoice>& choice,
                   std::optional<TriangleChoice>* without = nullptr);
  /// Called after the last key, before the rays are checked.
  virtual bool finish_more();

  /// The tmin of a ray that does not state one.
  double default_tmin_ = 0;
  /// The number of the first row of this body, for pointers.
  std::size_t first_ray_ = 0;
  RayQuery query_;

 private:
  // Reads the top level; the following functions read the forms of rays.
  bool read_top(Object object);
  bool read_rows(Value value);
  bool read_column(Value value, RayPart part);
  bool read_masks(Value value);
  bool read_generator(Value value);
  // Options, implemented in ray_options.cpp. Each function returns false after it has stored an
  // error.
  bool read_option(std::string_view key, Value value);
  bool read_fields(Value value);
  bool read_max_hits(Value value);
  bool read_crossings(Value value);
  bool read_cull(Value value, const JsonPointer& place, HitFilter& filter);
  bool read_mask(Value value, const JsonPointer& place, HitFilter& filter);
  bool read_filters(Value value);
  bool read_filter(Value value, const JsonPointer& place, HitFilter& filter);
  bool read_triangles(Value value, const JsonPointer& place, std::vector<TriangleName>& triangles);
  bool read_on_invalid(Value value);
  bool read_patterns(Value value, const JsonPointer& place, std::vector<std::string>& patterns);
  unsigned known_top_keys() const;
  bool finish_rows_or_columns();
  bool read_image(Value value);
  bool finish_image();
  /// Makes the rays, but not those of an image.
  bool finish_generator();

  template <class Place>
  bool read_limit(Value value, RayPart part, double& out, Place place);
  bool read_vector(Value value, std::size_t ray, RayPart part, Vec3d& out);

  static JsonPointer row_place(std::size_t ray, RayPart part, std::size_t component = kWholeTuple) {
    JsonPointer place = ray_place(ray);
    place.key(kRayRowKeys[static_cast<std::size_t>(part)]);
    if (component != kWholeTuple) place.index(component);
    return place;
  }
  static JsonPointer column_place(RayPart part, std::size_t element = kWholeTuple) {
    JsonPointer place;
    place.key(kRayColumnKeys[static_cast<std::size_t>(part)]);
    if (element != kWholeTuple) place.index(element);
    return place;
  }
  bool too_many(const JsonPointer& place) {
    return fail(ErrorKind::kTooLarge, "RAYS_TOO_MANY",
                "a request may hold at most " + std::to_string(rules_.max_rays) + " rays", place);
  }

  RayJsonRules rules_;
  unsigned seen_ = 0;  ///< bit set of the top-level keys so far, by index in kTopKeys
  std::array<std::uint64_t, 2> pixels_{};  ///< width and height of the generator's image, or 0
  std::optional<RayGenerator> generator_;
  double image_unit_ = HitImage().unit;
  std::array<std::size_t, 4> column_size_{};  ///< number of numbers read, by RayPart
};

}  // namespace sightline

// Tests: tests/unit/proto/ray_json_test.cpp
