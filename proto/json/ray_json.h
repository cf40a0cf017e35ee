#pragma once
/// Decodes rays from JSON, strictly: every accepted body has exactly one meaning. All other bodies
/// are an Error with a JSON pointer to the place.
///
///   rows     {"rays":[{"origin":[x,y,z],"direction":[x,y,z],"tmin":0,"tmax":10}],"fields":["t"]}
///   columns  {"origins":[x,y,z,...],"directions":[x,y,z,...],"tmin":[...],"tmax":[...],"fields":..}
///   generated  {"generator":{"kind":"pinhole",...}}, see generator_json.h; the answer has columns
///
/// Keys may be in any order. tmin, tmax and fields are optional; a null tmax means no limit.
/// Numbers become the nearest float64, so -0.0, subnormal numbers and 17 digits are retained.
///
///   cull              "none", "back", "front" or "material"
///   include, exclude  {"nodes":[3],"names":["tree*"],"materials":["leaves"]}, any of the three
///                     (core/query/hit_filter.h)
///   filters           {"list":[{"include":{..},"cull":"back"},{}],"rays":[0,1,0]}: of each ray the
///                     number of its filter, instead of cull, include, exclude and mask
///   mask, masks       5 for all rays; [1,4,...] as a column; "mask" in a row. A node
///                     counts only if its mask shares a bit with that of the ray
///   on_invalid        "refuse": an invalid ray is an error; "mark": only that ray is not answered
///   strict            true: an entry of include or exclude that matches nothing is an error
///   work              true: the answer contains its cost
///   image             "depth", "node", "normal", "visits", "node_colours" or "shaded", with
///                     "image_unit": 0.001 (hit_image.h)
///   normalize         true: tmin, tmax and the t of the answer are in scene units
///   explain           true, for a single ray: the boxes and triangles that it was tested with
///   crossings         "every" or "once", if hits are listed or counted
///   alpha             "opaque" or "cutoff": whether texels of masked materials are tested
///   timeout_ms        200: the longest time for the answer
///   threads           2: the most threads that work on the answer at once
///   max_hits          1000, for each ray, if hits are listed

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/column.h"
#include "core/base/result.h"
#include "core/query/hit_batch.h"
#include "core/query/hit_filter.h"
#include "core/query/ray_batch.h"
#include "core/query/ray_generators.h"
#include "proto/file_camera.h"
#include "proto/hit_fields.h"
#include "proto/hit_image.h"
#include "proto/json/hit_json.h"
#include "proto/table_format.h"

namespace sightline {

/// What a body may contain.
struct RayJsonRules {
  std::size_t max_rays = 10'000'000;
  /// False: the answer has no fields to choose from, so the key "fields" is unknown.
  bool has_fields = true;
  /// False: the body has options only.
  bool has_rays = true;
  FieldSet default_fields = kDefaultHitFields;  ///< of a body without "fields"
  FieldSet known_fields = kAllHitFields;        ///< others are FIELD_UNKNOWN
  /// True: the body may have the keys of rays through a scene: "normalize", "cull", "include",
  /// "exclude", "mask", "masks", "on_invalid", "work", "strict", "timeout_ms", "threads".
  bool has_scene = true;
  /// True: "timeout_ms" and "threads" are allowed without has_scene too.
  bool has_timeout = false;
  /// False: "normalize" and "on_invalid" are not allowed.
  bool has_marks = true;
  bool has_generator = true;    ///< true: "generator" is allowed
  bool has_culling = true;      ///< true: "cull" is allowed, if has_scene
  bool has_triangles = true;    ///< true: "include" and "exclude" may have "triangles"
  bool has_explain = false;     ///< true: "explain" is allowed
  bool has_image = false;       ///< true: "image" and "image_unit" are allowed
  bool has_alpha = false;       ///< true: "alpha" is allowed
  bool has_filters = false;     ///< true: "filters" is allowed
  bool has_returns = false;     ///< true: a generator may have several returns
  FindCamera find_camera = {};  ///< for generators of the kind "camera"; null: there is no scene
  /// True: "crossings" (or "max_hits") is allowed.
  bool has_crossings = false;
  bool has_max_hits = false;
  std::uint64_t max_hits = 10'000'000;  ///< the largest max_hits that is accepted
  /// Called before a generator makes `rays` rays or stores poses, but not for the rays of an image;
  /// its error becomes the answer. Empty: every number is admitted.
  std::function<Status(std::uint64_t rays)> admit_made = {};
};

/// The decoded options that questions about rays, points, sweeps, pairs and clearance share.
struct QueryOptions {
  FieldSet fields = kDefaultHitFields;
  std::vector<std::string> named_fields;  ///< what kNamed of `fields` stands for, in order
  bool chose_fields = false;              ///< the client chose fields; else they are the default
  AnswerLayout layout = AnswerLayout::kRows;
  std::optional<TableFormat> table;  ///< set if the answer is a file of rows or columns
  HitFilter filter;
  bool strict = false;      ///< a part of the filter that matches nothing is an error
  bool wants_work = false;  ///< the answer contains its cost
  std::optional<std::uint64_t> timeout_ms;  ///< the client's limit of the time for the answer
  int threads = 0;                          ///< the client's limit of threads; 0: no limit
};

/// A decoded body: rays with their options.
struct RayQuery : QueryOptions {
  RayBatch rays;  ///< checked by check_rays; none for an image
  Crossings crossings = Crossings::kEvery;
  /// Limits were in scene units (they are converted to t here), and the t of the answer is to be in
  /// scene units.
  bool normalize = false;
  /// Of "filters": the filters, and for each ray an index in them. Without the key both are empty.
  std::vector<HitFilter> ray_filters;
  Column<std::uint32_t> filter_of;
  /// "on_invalid":"mark": invalid rays are misses, and are listed in `invalid`
  bool marks_invalid = false;
  InvalidRays invalid;
  bool alpha_cutoff = false;  ///< transparent texels of masked materials do not count
  /// the answer contains the boxes that its one ray was tested with
  bool wants_explanation = false;
  std::optional<HitImage> image;       ///< its size is that of the camera
  std::optional<RayGenerator> camera;  ///< of the image: generate_rows makes its rays
  std::uint64_t returns = 1;           ///< number of slots that the answer has for each ray
  RangeNoise noise = {};               ///< errors of the distances of a lidar
  std::uint64_t max_hits = 1000;       ///< for each ray; the default may exceed the rules' limit

  /// The number of rays to trace.
  std::uint64_t ray_count() const { return image ? image->width * image->height : rays.size(); }
};

/// The bytes of capacity that must follow a body, because the parser reads in blocks.
inline constexpr std::size_t kRayJsonPadding = 64;

/// Decodes a body of rays. The text of `body` is not changed, but its capacity grows by
/// kRayJsonPadding if needed. The query does not refer to the body.
///
/// Errors, by status:
/// - 400: JSON_MALFORMED
/// - 422: KEY_UNKNOWN, KEY_DUPLICATE, KEY_MISSING, KEYS_MIXED (rows and columns in one body,
///   filters with cull, include, exclude, mask, image or explain),
///   TYPE_WRONG, LENGTH_WRONG, NUMBER_NOT_FINITE (NaN, Infinity, 1e999)
/// - 422: FIELD_UNKNOWN (names the known ones), FIELD_DUPLICATE, FIELDS_EMPTY, NUMBER_OUT_OF_RANGE
///   (max_hits, nodes, mask, masks, timeout_ms, threads, image_unit, filters), VALUE_UNKNOWN
///   (crossings, cull, on_invalid, image), EXPLAIN_ONE_RAY, EXPLAIN_IS_TEXT (explain with image),
///   IMAGE_WITHOUT_PIXELS, and the codes of check_rays and generate_rays
/// - 413: RAYS_TOO_MANY, FILTER_TOO_LARGE, FIELDS_TOO_MANY, BODY_TOO_LARGE (4 GiB and more)
/// - 507: MEMORY_FULL (the parser needs several times the body)
/// - those of rules.find_camera and rules.admit_made
Result<RayQuery> decode_rays(std::string& body, const RayJsonRules& rules);
/// Checks that "filters" has a number for each ray, once the rays are decoded. Errors: LENGTH_WRONG.
Status check_filters(const RayQuery& query);

/// The last step of every decoder: replaces invalid rays by rays that miss, if they are to be
/// marked, and converts limits to limits of t. Precondition: invalid rays are to be marked, or
/// there are none.
void finish_rays(RayQuery& query);

}  // namespace sightline
