#include "proto/json/ray_json.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "core/base/infinity.h"
#include "proto/json/generator_json.h"
#include "proto/json/plain_number.h"
#include "proto/json/plain_rays.h"
#include "proto/json/ray_reader.h"

namespace sightline {
namespace {

static_assert(kRayJsonPadding >= kJsonPadding && kJsonPadding >= kPlainPadding);

std::string number_text(std::size_t number) { return std::to_string(number); }

constexpr std::array<std::string_view, 24> kTopKeys{
    "rays",       "origins",    "directions", "tmin",    "tmax",    "fields",
    "max_hits",   "crossings",  "normalize",  "cull",    "include", "exclude",
    "on_invalid", "work",       "generator",  "explain", "mask",    "masks",
    "image",      "image_unit", "timeout_ms", "strict",  "alpha",   "threads"};
constexpr unsigned kMaskBit = 1u << 16, kMasksBit = 1u << 17, kImageBits = 3u << 18,
                   kTimeoutBit = 1u << 20 | 1u << 23, kStrictBit = 1u << 21;
constexpr unsigned kRaysBit = 1u << 0, kColumnBits = 0x1eu | kMasksBit, kFieldsBit = 1u << 5,
                   kMaxHitsBit = 1u << 6, kCrossingsBit = 1u << 7,
                   kSceneBits = 0x3f00u | kMaskBit | kTimeoutBit | kStrictBit,
                   kMarkBits = 1u << 8 | 1u << 12, kGeneratorBit = 1u << 14, kCullBit = 1u << 9,
                   kExplainBit = 1u << 15, kAlphaBit = 1u << 22,
                   kUnfilteredBits = kCullBit | 3u << 10 | kMaskBit | kImageBits | kExplainBit;
/// The first key that is an option.
constexpr std::size_t kFirstOption = 5;
/// Every key of a row, the last of them only where there is a scene.
constexpr unsigned kRowBits = 0xfu, kRowMaskBit = 0x10u;
constexpr std::uint64_t kMostMask = 0xffffffffu;

}  // namespace

template <class Place>
bool RayReader::read_limit(Value value, RayPart part, double& out, Place place) {
  return part == RayPart::kTmax ? read_number_or_null(value, kInf, out, place)
                                : read_number(value, out, place);
}

bool RayReader::read_vector(Value value, std::size_t ray, RayPart part, Vec3d& out) {
  Array array;
  if (value.get_array().get(array) != simdjson::SUCCESS) {
    return wrong(value, row_place(ray, part), "an array of three numbers");
  }
  int count = 0;
  for (auto element : array) {
    Value number;
    if (const auto code = element.get(number); code != simdjson::SUCCESS) {
      return check_end(code, [&] { return row_place(ray, part); });
    }
    double component = 0;
    if (!read_number(number, component,
                     [&] { return row_place(ray, part, static_cast<std::size_t>(count)); })) {
      return false;
    }
    if (count == 3) {
      return fail(ErrorKind::kInvalid, "LENGTH_WRONG", "expected three numbers, found more",
                  row_place(ray, part));
    }
    out[count++] = component;
  }
  if (count == 3) return true;
  return fail(ErrorKind::kInvalid, "LENGTH_WRONG",
              "expected three numbers, found " + std::to_string(count), row_place(ray, part));
}

bool RayReader::read_row(Value value, std::size_t ray) {
  Object object;
  if (value.get_object().get(object) != simdjson::SUCCESS) {
    return wrong(value, ray_place(ray), "an object");
  }
  Ray row;
  row.tmin = default_tmin_;
  std::uint64_t mask = kMostMask;
  unsigned seen = 0;
  for (auto entry : object) {
    Field field;
    if (const auto code = std::move(entry).get(field); code != simdjson::SUCCESS) {
      return check_end(code, [&] { return ray_place(ray); });
    }
    // The usual order of keys is tried first.
    std::size_t which = 0;
    const simdjson::ondemand::raw_json_string raw = field.key();
    if (raw.unsafe_is_equal(kRayRowKeys[1])) {
      which = 1;
    } else if (!raw.unsafe_is_equal(kRayRowKeys[0]) &&
               !read_key(field, kRayRowKeys, rules_.has_scene ? kRowBits | kRowMaskBit : kRowBits,
                         ray_place(ray), which)) {
      return false;
    }
    const auto part = static_cast<RayPart>(which);
    if ((seen & (1u << which)) != 0) return mark_seen(1u << which, seen, row_place(ray, part));
    seen |= 1u << which;

    if (part == RayPart::kMask) {
      if (!read_count(field.value(), kMostMask, mask, row_place(ray, part))) return false;
    } else if (part == RayPart::kOrigin || part == RayPart::kDirection) {
      Vec3d& vector = part == RayPart::kOrigin ? row.origin : row.direction;
      if (!read_vector(field.value(), ray, part, vector)) return false;
    } else {
      double& limit = part == RayPart::kTmin ? row.tmin : row.tmax;
      if (!read_limit(field.value(), part, limit, [&] { return row_place(ray, part); })) {
        return false;
      }
    }
  }
  for (const RayPart part : {RayPart::kOrigin, RayPart::kDirection}) {
    if ((seen & (1u << static_cast<unsigned>(part))) == 0) {
      return fail(ErrorKind::kInvalid, "KEY_MISSING",
                  "a ray needs an origin and a direction; missing: " +
                      std::string(kRayRowKeys[static_cast<std::size_t>(part)]),
                  ray_place(ray));
    }
  }
  push_row(row, static_cast<std::uint32_t>(mask));
  return true;
}

void RayReader::push_row(const Ray& row, std::uint32_t mask) {
  Column<std::uint32_t>& masks = query_.rays.mask;
  if (masks.empty() && mask != kMostMask) masks.assign(query_.rays.size(), kMostMask);
  query_.rays.push_back(row);
  if (!masks.empty() || mask != kMostMask) masks.push_back(mask);
}

bool RayReader::read_rows(Value value) {
  Array array;
  if (value.get_array().get(array) != simdjson::SUCCESS) {
    return wrong(value, JsonPointer().key("rays"), "an array of rays");
  }
  std::size_t ray = 0;
  for (auto element : array) {
    Value row;
    if (const auto code = element.get(row); code != simdjson::SUCCESS) {
      return check_end(code, [&] { return ray_place(ray); });
    }
    if (ray == rules_.max_rays) return too_many(ray_place(ray));
    if (!read_row(row, ray)) return false;
    ++ray;
  }
  return true;
}

bool RayReader::read_column(Value value, RayPart part) {
  Array array;
  if (value.get_array().get(array) != simdjson::SUCCESS) {
    return wrong(value, column_place(part), "an array of numbers");
  }
  RayBatch& rays = query_.rays;
  const bool vector = part == RayPart::kOrigin || part == RayPart::kDirection;
  const std::size_t width = vector ? 3 : 1;
  std::array<UnsetColumn<double>*, 3> columns{};
  switch (part) {
    case RayPart::kOrigin:
      columns = {&rays.ox, &rays.oy, &rays.oz};
      break;
    case RayPart::kDirection:
      columns = {&rays.dx, &rays.dy, &rays.dz};
      break;
    case RayPart::kTmin:
      columns = {&rays.tmin, nullptr, nullptr};
      break;
    case RayPart::kTmax:
    case RayPart::kMask:
      columns = {&rays.tmax, nullptr, nullptr};
      break;
  }
  // max_rays is a limit of memory: a column longer than that is refused while it is read.
  const std::size_t most =
      rules_.max_rays > kWholeTuple / width ? kWholeTuple : rules_.max_rays * width;
  // Of plain columns all was taken already, and an empty array is left.
  std::size_t count = columns[0]->size() * width, component = 0;
  for (auto element : array) {
    Value number;
    if (const auto code = element.get(number); code != simdjson::SUCCESS) {
      return check_end(code, [&] { return column_place(part, count); });
    }
    if (count == most) return too_many(column_place(part, count));
    double scalar = 0;
    const auto place = [&] { return column_place(part, count); };
    if (vector ? !read_number(number, scalar, place) : !read_limit(number, part, scalar, place)) {
      return false;
    }
    columns[component]->push_back(scalar);
    component = component + 1 == width ? 0 : component + 1;
    ++count;
  }
  if (component != 0) {
    return fail(ErrorKind::kInvalid, "LENGTH_WRONG",
                "needs three numbers for each ray, has " + number_text(count), column_place(part));
  }
  column_size_[static_cast<std::size_t>(part)] = count;
  return true;
}

bool RayReader::read_masks(Value value) {
  const JsonPointer place = JsonPointer().key("masks");
  return read_array(value, "an array of masks", place, [&](std::size_t i, Value entry) {
    if (i == rules_.max_rays) return too_many(place);
    std::uint64_t mask = 0;
    if (!read_count(entry, kMostMask, mask, JsonPointer(place).index(i))) return false;
    query_.rays.mask.push_back(static_cast<std::uint32_t>(mask));
    return true;
  });
}

unsigned RayReader::known_top_keys() const {
  unsigned known = rules_.has_rays ? kRaysBit | kColumnBits : 0;
  if (!rules_.has_scene) known &= ~kMasksBit;
  if (rules_.has_fields) known |= kFieldsBit;
  if (rules_.has_max_hits) known |= kMaxHitsBit;
  if (rules_.has_crossings) known |= kCrossingsBit;
  if (rules_.has_scene) known |= kSceneBits;
  if (rules_.has_timeout) known |= kTimeoutBit;
  if (!rules_.has_marks) known &= ~kMarkBits;
  if (!rules_.has_culling) known &= ~kCullBit;
  if (rules_.has_rays && rules_.has_generator) known |= kGeneratorBit;
  if (rules_.has_rays && rules_.has_explain) known |= kExplainBit;
  if (rules_.has_image) known |= kImageBits;
  if (rules_.has_alpha) known |= kAlphaBit;
  return known;
}

bool RayReader::read_top(Object object) {
  // Keys of the kind of body follow those of rays.
  std::array<std::string_view, kMostKeys> all_keys;
  static_assert(kTopKeys.size() + kMostMoreKeys <= kMostKeys);
  const auto more = std::copy(kTopKeys.begin(), kTopKeys.end(), all_keys.begin());
  const auto end = std::copy(more_keys().begin(), more_keys().end(), more);
  const std::span<const std::string_view> keys(all_keys.begin(), end);
  const unsigned known = known_top_keys() | known_more_keys() << kTopKeys.size();
  for (auto entry : object) {
    Field field;
    if (const auto code = std::move(entry).get(field); code != simdjson::SUCCESS) {
      return check_end(code, [] { return JsonPointer(); });
    }
    std::size_t which = 0;
    if (!read_key(field, keys, known, JsonPointer(), which)) return false;
    const unsigned bit = 1u << which;
    const JsonPointer place = JsonPointer().key(keys[which]);
    if (!mark_seen(bit, seen_, place)) return false;
    if (((seen_ & kRaysBit) != 0) + ((seen_ & kColumnBits) != 0) + ((seen_ & kGeneratorBit) != 0) >
        1) {
      return fail(
          ErrorKind::kInvalid, "KEYS_MIXED",
          "rays come as rows (\"rays\"), as columns (\"origins\", \"directions\") or from a "
          "generator, not as two of these",
          place);
    }
    const Value value = field.value();
    if (which >= kTopKeys.size()) {
      if (!read_more(which - kTopKeys.size(), value)) return false;
      continue;
    }
    const bool good = which == 0             ? read_rows(value)
                      : bit == kMasksBit     ? read_masks(value)
                      : which < kFirstOption ? read_column(value, static_cast<RayPart>(which - 1))
                      : bit == kGeneratorBit ? read_generator(value)
                                             : read_option(keys[which], value);
    if (!good) return false;
  }
  return true;
}

bool RayReader::finish_rows_or_columns() {
  if ((seen_ & kRaysBit) != 0 || !rules_.has_rays) return true;
  query_.layout = AnswerLayout::kColumns;
  if ((seen_ & kGeneratorBit) != 0) return true;
  for (const RayPart part : {RayPart::kOrigin, RayPart::kDirection}) {
    if ((seen_ & (2u << static_cast<unsigned>(part))) == 0) {
      const std::string key(kRayColumnKeys[static_cast<std::size_t>(part)]);
      return fail(ErrorKind::kInvalid, "KEY_MISSING",
                  (seen_ & kColumnBits) == 0
                      ? "needs \"rays\", or \"origins\" and \"directions\""
                      : "columns need origins and directions; missing: " + key,
                  JsonPointer());
    }
  }
  const std::size_t count = column_size_[0] / 3;
  if (column_size_[1] != column_size_[0]) {
    return fail(ErrorKind::kInvalid, "LENGTH_WRONG",
                "has " + number_text(column_size_[1]) + " numbers, origins has " +
                    number_text(column_size_[0]),
                column_place(RayPart::kDirection));
  }
  if ((seen_ & kMasksBit) != 0 && query_.rays.mask.size() != count) {
    return fail(ErrorKind::kInvalid, "LENGTH_WRONG",
                "has " + number_text(query_.rays.mask.size()) + " numbers for " +
                    number_text(count) + " rays",
                JsonPointer().key("masks"));
  }
  for (const RayPart part : {RayPart::kTmin, RayPart::kTmax}) {
    UnsetColumn<double>& column = part == RayPart::kTmin ? query_.rays.tmin : query_.rays.tmax;
    if ((seen_ & (2u << static_cast<unsigned>(part))) == 0) {
      if (part == RayPart::kTmin) {
        column.assign(count, default_tmin_);
      } else {
        column.assign(count, kInf);
      }
    } else if (column.size() != count) {
      return fail(
          ErrorKind::kInvalid, "LENGTH_WRONG",
          "has " + number_text(column.size()) + " numbers for " + number_text(count) + " rays",
          column_place(part));
    }
  }
  return true;
}

bool RayReader::finish_more() {
  const bool is_mixed = (seen_ & kUnfilteredBits) != 0 || query_.fields.has_any_of(kCostFields);
  if (query_.ray_filters.empty() || !is_mixed) return true;
  return invalid("KEYS_MIXED",
                 "with filters of rays there is no cull, include, exclude, mask, image, explain "
                 "and cost of rays",
                 JsonPointer().key("filters"));
}

bool RayReader::finish_image() {
  const JsonPointer place = JsonPointer().key("image");
  if (!query_.image) {
    return (seen_ & kImageBits) == 0 ||
           invalid("KEY_MISSING", "\"image_unit\" is that of an \"image\"", JsonPointer());
  }
  if (query_.wants_explanation)
    return invalid("EXPLAIN_IS_TEXT", "an explanation comes as JSON alone", place);
  if (pixels_[0] == 0 || pixels_[1] == 0) {
    return invalid("IMAGE_WITHOUT_PIXELS",
                   "an image needs a generator with width and height, and no list of pixels",
                   place);
  }
  query_.image->width = pixels_[0];
  query_.image->height = pixels_[1];
  query_.image->unit = image_unit_;
  query_.layout = AnswerLayout::kImage;
  return true;
}

bool RayReader::check_limits_and_directions() {
  if (query_.wants_explanation && query_.rays.size() != 1) {
    return invalid("EXPLAIN_ONE_RAY", "one ray at a time can be explained",
                   JsonPointer().key("explain"));
  }
  if (query_.wants_explanation && query_.alpha_cutoff) {
    return invalid("KEYS_MIXED", "an explanation does not include \"alpha\":\"cutoff\"",
                   JsonPointer().key("explain"));
  }
  RayFault fault;
  if (query_.marks_invalid || check_rays(query_.rays, fault)) return true;
  std::string_view part_name = fault.part;
  // A tmin of 0 may be the default: then what the client wrote is the tmax.
  if (part_name == "tmin" && query_.rays.tmin[fault.ray] == 0) part_name = "tmax";
  const auto part = static_cast<RayPart>(
      std::find(kRayRowKeys.begin(), kRayRowKeys.end(), part_name) - kRayRowKeys.begin());
  const bool vector = part == RayPart::kOrigin || part == RayPart::kDirection;
  return fail(ErrorKind::kInvalid, fault.code, fault.message,
              query_.layout != AnswerLayout::kColumns
                  ? row_place(first_ray_ + fault.ray, part)
                  : column_place(part, vector ? fault.ray * 3 : fault.ray));
}

Result<RayQuery> RayReader::read(std::string& body) {
  const auto read_object = [&](Object object) { return read_top(object); };
  body.reserve(body.size() + kJsonPadding);
  PlainArrays plain;
  const bool is_plain =
      rules_.has_rays && take_plain_arrays(body, rules_.max_rays, default_tmin_, plain);
  if (is_plain) query_.rays = std::move(plain.rays);
  if (!read_body(is_plain ? plain.rest : body, read_object) || !finish_rows_or_columns() ||
      !finish_more() || !finish_image() || !finish_generator() || !check_limits_and_directions()) {
    return error();
  }
  finish_rays(query_);
  return std::move(query_);
}

Result<QueryOptions> RayReader::read_options(std::string& body) {
  Result<RayQuery> query = read(body);
  if (!query) return std::move(query).error();
  return std::move(static_cast<QueryOptions&>(*query));
}

Result<RayQuery> decode_rays(std::string& body, const RayJsonRules& rules) {
  return RayReader(rules).read(body);
}

bool RayReader::read_generator(Value value) {
  // Few bytes ask for these: no more memory than the largest body may ask for by itself.
  constexpr std::size_t kMostMade = std::size_t{1} << 22;
  RayGenerator& generator = generator_.emplace();
  const std::uint64_t most = std::min(rules_.max_rays, kMostMade);
  if (!GeneratorReader(*this, most, rules_.find_camera, rules_.admit_made).read(value, generator))
    return false;
  if (const auto image = image_of(generator)) pixels_ = {image->width, image->height};
  if (!rules_.has_returns && (generator.returns > 1 || generator.noise.is_used())) {
    return invalid("KEY_UNKNOWN",
                   "several returns, noise and dropout are answered by rays:closest alone",
                   JsonPointer()
                       .key("generator")
                       .key(generator.returns > 1       ? "returns"
                            : generator.noise.sigma > 0 ? "noise"
                                                        : "dropout"));
  }
  query_.returns = generator.returns;
  query_.noise = generator.noise;
  return true;
}

bool RayReader::finish_generator() {
  if (!generator_) return true;
  if (query_.image) {
    query_.camera = std::move(generator_);
    return true;
  }
  const JsonPointer place = JsonPointer().key("generator");
  if (rules_.admit_made) {
    const Status admitted = rules_.admit_made(ray_count(*generator_));
    if (!admitted)
      return fail(admitted.error().kind, admitted.error().code, admitted.error().message, place);
  }
  auto rays = generate_rays(*generator_);
  if (!rays) return invalid(rays.error().code, rays.error().message, place);
  query_.rays = std::move(*rays);
  return true;
}

void finish_rays(RayQuery& query) {
  if (query.marks_invalid) query.invalid = replace_invalid(query.rays);
  if (query.normalize) scale_limits_to_t(query.rays);
}

}  // namespace sightline
