#pragma once
/// Rays as JSON, strictly: every accepted body has exactly one meaning. Everything else is an Error
/// with a JSON pointer to the place.
///
///   rows     {"rays":[{"origin":[x,y,z],"direction":[x,y,z],"tmin":0,"tmax":10}],"fields":["t"]}
///   columns  {"origins":[x,y,z,...],"directions":[x,y,z,...],"tmin":[...],"tmax":[...],"fields":..}
///   made     {"generator":{"kind":"pinhole",...}}, see generator_json.h; the answer has columns
///
/// Keys come in any order. tmin, tmax and fields may be left out; null as a tmax means no limit.
/// Numbers become the nearest float64: -0.0, denormals and 17 digits survive.
///
///   cull              "none", "back", "front" or "material"
///   include, exclude  {"nodes":[3],"names":["tree*"],"materials":["leaves"]}, any of the three: see
///                     core/query/hit_filter.h
///   mask, masks       5 for all rays, [1,4,...] as a column, "mask" in a row: what has no bit in
///                     common does not count
///   on_invalid        "refuse" or "mark": the effect of a bad ray on the others
///   strict            true: an entry of include or exclude that matches nothing is an error
///   work              true: the answer has its cost
///   image             "depth", "node", "normal" or "visits", with "image_unit": 0.001: hit_image.h
///   normalize         true: tmin, tmax and the t of the answer count in scene units
///   explain           true, for a single ray: the boxes and triangles that it was tested with
///   crossings         "every" or "once", where hits are listed or counted
///   max_hits          1000, for each ray, where hits are listed

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/query/hit_batch.h"
#include "core/query/hit_filter.h"
#include "core/query/ray_batch.h"
#include "proto/file_camera.h"
#include "proto/hit_fields.h"
#include "proto/hit_image.h"
#include "proto/json/hit_json.h"

namespace sightline {

struct RayJsonRules {
  std::size_t max_rays = 10'000'000;
  /// Whether the answer has fields to choose from; without, the key "fields" is unknown.
  bool has_fields = true;
  /// Without, the body has options only.
  bool has_rays = true;
  FieldSet default_fields = kDefaultHitFields;
  FieldSet known_fields = kAllHitFields;
  /// Whether the body may have the keys of rays through a scene: "normalize", "cull", "include",
  /// "exclude", "on_invalid", "work", "strict", "timeout_ms".
  bool has_scene = true;
  /// Whether "timeout_ms" may stand there without a scene too.
  bool has_timeout = false;
  /// Whether "normalize" and "on_invalid" are among them.
  bool has_marks = true;
  bool has_generator = true;
  bool has_culling = true;
  bool has_explain = false;
  bool has_image = false;    ///< "image" and "image_unit"
  bool has_returns = false;  ///< whether a generator may ask for several
  FindCamera find_camera = {};
  /// Whether the body may have "crossings" and "max_hits".
  bool has_crossings = false;
  bool has_max_hits = false;
  std::uint64_t max_hits = 10'000'000;  ///< the largest max_hits that is accepted
  /// Called before so many rays are made of a generator, or poses are stored for it; its error is
  /// the answer. Empty: all are allowed.
  std::function<Status(std::uint64_t rays)> admit_made = {};
};

struct RayQuery {
  RayBatch rays;  ///< checked by check_rays
  FieldSet fields = kDefaultHitFields;
  AnswerLayout layout = AnswerLayout::kRows;
  Crossings crossings = Crossings::kEvery;
  /// Limits came in scene units (they are limits of t here), and t is to be answered so.
  bool normalize = false;
  HitFilter filter;
  bool marks_invalid = false;  ///< "on_invalid":"mark": bad rays miss, and are named in `invalid`
  InvalidRays invalid;
  bool wants_work = false;
  bool strict = false;  ///< a part of the filter that matches nothing is an error
  std::optional<std::uint64_t> timeout_ms;  ///< the answer may take no longer
  bool wants_explanation = false;           ///< of its one ray
  std::optional<HitImage> image;            ///< with the pixels of the generator
  bool chose_fields = false;                ///< else they are the default
  std::uint64_t returns = 1;                ///< how many slots the answer has for each ray
  std::uint64_t max_hits = 1000;  ///< of each ray; may be more than the rules' when left out
};

/// Capacity behind its end that a body needs, because the parser reads in blocks.
inline constexpr std::size_t kRayJsonPadding = 64;

/// `body` is only read; its capacity grows by kRayJsonPadding where it has not as much to spare.
/// The batch does not point into it.
///
/// Errors, by status:
/// - 400: JSON_MALFORMED
/// - 422: KEY_UNKNOWN, KEY_DUPLICATE, KEY_MISSING, KEYS_MIXED (rows and columns in one body),
///   TYPE_WRONG, LENGTH_WRONG, NUMBER_NOT_FINITE (NaN, Infinity, 1e999)
/// - 422: FIELD_UNKNOWN (names the known ones), FIELD_DUPLICATE, FIELDS_EMPTY, NUMBER_OUT_OF_RANGE
///   (max_hits, nodes), VALUE_UNKNOWN (crossings, cull, on_invalid), EXPLAIN_ONE_RAY, and the codes
///   of check_rays
/// - 413: RAYS_TOO_MANY, FILTER_TOO_LARGE, BODY_TOO_LARGE (4 GiB and more)
/// - 507: MEMORY_FULL (the parser needs several times the body)
Result<RayQuery> decode_rays(std::string& body, const RayJsonRules& rules);

/// The last step of every decoder: puts rays that miss in the place of bad ones where those are to
/// be marked, and turns limits into limits of t. Precondition: they are to be marked, or all are
/// good.
void finish_rays(RayQuery& query);

}  // namespace sightline
