#include "proto/ray_json.h"

// Checks of the end of the text inside the parser as well: this room trusts no body.
#define SIMDJSON_CHECK_EOF 1
#include <simdjson.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <span>

#include "proto/json_pointer.h"
#include "proto/json_token.h"

namespace sightline {
namespace {

namespace od = simdjson::ondemand;

constexpr double kInf = std::numeric_limits<double>::infinity();
/// As a place in a tuple: the tuple itself.
constexpr std::size_t kWhole = static_cast<std::size_t>(-1);

std::string number_text(std::size_t number) { return std::to_string(number); }

/// The parts of a ray, as rows and as columns call them.
enum class Part { kOrigin, kDirection, kTmin, kTmax };
constexpr std::array<std::string_view, 4> kRowKeys{"origin", "direction", "tmin", "tmax"};
constexpr std::array<std::string_view, 4> kColumnKeys{"origins", "directions", "tmin", "tmax"};

/// Reads one body. Every read_... returns false after it has filled error_; nothing is read then.
class RayReader {
 public:
  explicit RayReader(const RayJsonRules& rules) : rules_(rules) {}

  Result<RayQuery> read(std::string& body);

 private:
  // The top level, then one function for each form of rays.
  bool read_top(od::object object);
  bool read_rows(od::value value);
  bool read_row(od::value value, std::size_t ray);
  bool read_column(od::value value, Part part);
  bool read_fields(od::value value);
  bool read_max_hits(od::value value);
  bool read_crossings(od::value value);
  unsigned known_top_keys() const;
  bool finish_rows_or_columns();
  bool check_limits_and_directions();

  // Single values. `place` makes the pointer, and is only called when there is something to say.
  template <class Place>
  bool read_number(od::value value, double& out, Place place);
  template <class Place>
  bool read_limit(od::value value, Part part, double& out, Place place);
  bool read_vector(od::value value, std::size_t ray, Part part, Vec3d& out);
  bool read_key(od::field& field, std::span<const std::string_view> keys, unsigned known,
                const JsonPointer& parent, std::size_t& which);
  bool mark_seen(unsigned bit, unsigned& seen, const JsonPointer& place);
  template <class Place>
  bool check_end(simdjson::error_code code, Place place);

  bool fail(ErrorKind kind, std::string_view code, std::string message, const JsonPointer& place) {
    error_ = Error{kind, std::string(code), std::move(message), place.text()};
    return false;
  }
  bool malformed(const JsonPointer& place, std::string message) {
    return fail(ErrorKind::kMalformed, "JSON_MALFORMED", std::move(message), place);
  }
  /// Says why `value` is not what was expected there.
  bool wrong(od::value value, const JsonPointer& place, std::string_view expected);

  static JsonPointer ray_place(std::size_t ray) { return JsonPointer().key("rays").index(ray); }
  static JsonPointer row_place(std::size_t ray, Part part, std::size_t component = kWhole) {
    JsonPointer place = ray_place(ray);
    place.key(kRowKeys[static_cast<std::size_t>(part)]);
    if (component != kWhole) place.index(component);
    return place;
  }
  static JsonPointer column_place(Part part, std::size_t element = kWhole) {
    JsonPointer place;
    place.key(kColumnKeys[static_cast<std::size_t>(part)]);
    if (element != kWhole) place.index(element);
    return place;
  }
  bool too_many(const JsonPointer& place) {
    return fail(ErrorKind::kTooLarge, "RAYS_TOO_MANY",
                "a request may hold " + number_text(rules_.max_rays) + " rays", place);
  }

  RayJsonRules rules_;
  RayQuery query_;
  unsigned seen_ = 0;                         ///< top-level keys, by their number in kTopKeys
  std::array<std::size_t, 4> column_size_{};  ///< numbers read, by Part
  Error error_;
};

constexpr std::array<std::string_view, 8> kTopKeys{"rays", "origins", "directions", "tmin",
                                                   "tmax", "fields",  "max_hits",   "crossings"};
constexpr unsigned kRaysBit = 1u << 0, kColumnBits = 0x1eu, kFieldsBit = 1u << 5,
                   kMaxHitsBit = 1u << 6, kCrossingsBit = 1u << 7;
/// Every key of a row.
constexpr unsigned kRowBits = 0xfu;

bool RayReader::wrong(od::value value, const JsonPointer& place, std::string_view expected) {
  const std::string_view token = trim(value.raw_json_token());
  if (is_non_finite_word(token)) {
    return fail(ErrorKind::kInvalid, "NUMBER_NOT_FINITE", "NaN and infinities are not JSON numbers",
                place);
  }
  if (!looks_like_json(token)) return malformed(place, "this is not JSON");
  if (is_json_number(token) && expected == "a number") {
    return fail(ErrorKind::kInvalid, "NUMBER_NOT_FINITE", "this number overflows a float64", place);
  }
  return fail(ErrorKind::kInvalid, "TYPE_WRONG",
              "expected " + std::string(expected) + ", found " + std::string(token_kind(token)),
              place);
}

template <class Place>
bool RayReader::read_number(od::value value, double& out, Place place) {
  if (value.get_double().get(out) == simdjson::SUCCESS) return true;
  return wrong(value, place(), "a number");
}

template <class Place>
bool RayReader::read_limit(od::value value, Part part, double& out, Place place) {
  if (value.get_double().get(out) == simdjson::SUCCESS) return true;
  if (part == Part::kTmax && trim(value.raw_json_token()) == "null") {
    // get_double has stepped over the token already.
    out = kInf;
    return true;
  }
  return wrong(value, place(), "a number");
}

template <class Place>
bool RayReader::check_end(simdjson::error_code code, Place place) {
  if (code == simdjson::SUCCESS) return true;
  return malformed(place(), std::string("not well-formed here: ") + simdjson::error_message(code));
}

/// `known`: the bits of those of `keys` that may stand here.
bool RayReader::read_key(od::field& field, std::span<const std::string_view> keys, unsigned known,
                         const JsonPointer& parent, std::size_t& which) {
  const auto is_known = [&](std::size_t i) { return ((known >> i) & 1u) != 0; };
  const od::raw_json_string raw = field.key();
  for (which = 0; which < keys.size(); ++which) {
    if (is_known(which) && raw.unsafe_is_equal(keys[which])) return true;
  }
  // The same name may be written with escapes.
  std::string_view name;
  if (field.unescaped_key().get(name) != simdjson::SUCCESS) {
    return malformed(parent, "a key here is not a valid string");
  }
  std::string list;
  for (which = 0; which < keys.size(); ++which) {
    if (!is_known(which)) continue;
    if (name == keys[which]) return true;
    list += (list.empty() ? "" : ", ") + std::string(keys[which]);
  }
  return fail(ErrorKind::kInvalid, "KEY_UNKNOWN",
              "unknown key \"" + std::string(cut_utf8(name, 64)) + "\"; known here: " + list,
              JsonPointer(parent).key(name));
}

bool RayReader::mark_seen(unsigned bit, unsigned& seen, const JsonPointer& place) {
  if ((seen & bit) != 0) {
    return fail(ErrorKind::kInvalid, "KEY_DUPLICATE", "this key stands here twice", place);
  }
  seen |= bit;
  return true;
}

bool RayReader::read_vector(od::value value, std::size_t ray, Part part, Vec3d& out) {
  od::array array;
  if (value.get_array().get(array) != simdjson::SUCCESS) {
    return wrong(value, row_place(ray, part), "an array of three numbers");
  }
  int count = 0;
  for (auto element : array) {
    od::value number;
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

bool RayReader::read_row(od::value value, std::size_t ray) {
  od::object object;
  if (value.get_object().get(object) != simdjson::SUCCESS) {
    return wrong(value, ray_place(ray), "an object");
  }
  Ray row;
  unsigned seen = 0;
  for (auto entry : object) {
    od::field field;
    if (const auto code = std::move(entry).get(field); code != simdjson::SUCCESS) {
      return check_end(code, [&] { return ray_place(ray); });
    }
    // The usual order of keys is tried first.
    std::size_t which = 0;
    const od::raw_json_string raw = field.key();
    if (raw.unsafe_is_equal(kRowKeys[1])) {
      which = 1;
    } else if (!raw.unsafe_is_equal(kRowKeys[0]) &&
               !read_key(field, kRowKeys, kRowBits, ray_place(ray), which)) {
      return false;
    }
    const auto part = static_cast<Part>(which);
    if ((seen & (1u << which)) != 0) return mark_seen(1u << which, seen, row_place(ray, part));
    seen |= 1u << which;

    if (part == Part::kOrigin || part == Part::kDirection) {
      Vec3d& vector = part == Part::kOrigin ? row.origin : row.direction;
      if (!read_vector(field.value(), ray, part, vector)) return false;
    } else {
      double& limit = part == Part::kTmin ? row.tmin : row.tmax;
      if (!read_limit(field.value(), part, limit, [&] { return row_place(ray, part); })) {
        return false;
      }
    }
  }
  for (const Part part : {Part::kOrigin, Part::kDirection}) {
    if ((seen & (1u << static_cast<unsigned>(part))) == 0) {
      return fail(ErrorKind::kInvalid, "KEY_MISSING",
                  "a ray needs an origin and a direction; missing: " +
                      std::string(kRowKeys[static_cast<std::size_t>(part)]),
                  ray_place(ray));
    }
  }
  query_.rays.push_back(row);
  return true;
}

bool RayReader::read_rows(od::value value) {
  od::array array;
  if (value.get_array().get(array) != simdjson::SUCCESS) {
    return wrong(value, JsonPointer().key("rays"), "an array of rays");
  }
  std::size_t ray = 0;
  for (auto element : array) {
    od::value row;
    if (const auto code = element.get(row); code != simdjson::SUCCESS) {
      return check_end(code, [&] { return ray_place(ray); });
    }
    if (ray == rules_.max_rays) return too_many(ray_place(ray));
    if (!read_row(row, ray)) return false;
    ++ray;
  }
  return true;
}

bool RayReader::read_column(od::value value, Part part) {
  od::array array;
  if (value.get_array().get(array) != simdjson::SUCCESS) {
    return wrong(value, column_place(part), "an array of numbers");
  }
  RayBatch& rays = query_.rays;
  const bool vector = part == Part::kOrigin || part == Part::kDirection;
  const std::size_t width = vector ? 3 : 1;
  std::array<Column<double>*, 3> columns{};
  switch (part) {
    case Part::kOrigin:
      columns = {&rays.ox, &rays.oy, &rays.oz};
      break;
    case Part::kDirection:
      columns = {&rays.dx, &rays.dy, &rays.dz};
      break;
    case Part::kTmin:
      columns = {&rays.tmin, nullptr, nullptr};
      break;
    case Part::kTmax:
      columns = {&rays.tmax, nullptr, nullptr};
      break;
  }
  // max_rays is a limit of memory: a column longer than that is refused while it is read.
  const std::size_t most = rules_.max_rays > kWhole / width ? kWhole : rules_.max_rays * width;
  std::size_t count = 0, component = 0;
  for (auto element : array) {
    od::value number;
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

bool RayReader::read_fields(od::value value) {
  const auto all_names = [] {
    std::string list;
    for (const HitField field : all_hit_fields()) {
      list += (list.empty() ? "" : ", ") + std::string(hit_field_name(field));
    }
    return list;
  };
  const JsonPointer place = JsonPointer().key("fields");
  od::array array;
  if (value.get_array().get(array) != simdjson::SUCCESS) {
    return wrong(value, place, "an array of names");
  }
  FieldSet fields;
  std::size_t count = 0;
  for (auto element : array) {
    od::value entry;
    if (const auto code = element.get(entry); code != simdjson::SUCCESS) {
      return check_end(code, [] { return JsonPointer().key("fields"); });
    }
    const JsonPointer entry_place = JsonPointer(place).index(count++);
    std::string_view name;
    if (const auto code = entry.get_string().get(name); code != simdjson::SUCCESS) {
      if (code == simdjson::INCORRECT_TYPE) return wrong(entry, entry_place, "a name");
      return malformed(entry_place, "this is not a valid string");
    }
    const std::optional<HitField> field = find_hit_field(name);
    if (!field) {
      return fail(
          ErrorKind::kInvalid, "FIELD_UNKNOWN",
          "unknown field \"" + std::string(cut_utf8(name, 64)) + "\"; known: " + all_names(),
          entry_place);
    }
    if (fields.has(*field)) {
      return fail(ErrorKind::kInvalid, "FIELD_DUPLICATE", "this field is asked for twice",
                  entry_place);
    }
    fields.add(*field);
  }
  if (fields.empty()) {
    return fail(ErrorKind::kInvalid, "FIELDS_EMPTY",
                "leave \"fields\" out, or name some of: " + all_names(), place);
  }
  query_.fields = fields;
  return true;
}

bool RayReader::read_max_hits(od::value value) {
  const JsonPointer place = JsonPointer().key("max_hits");
  const std::string expected = "an integer from 0 to " + number_text(rules_.max_hits);
  std::uint64_t count = 0;
  const bool integer = value.get_uint64().get(count) == simdjson::SUCCESS;
  if (!integer && !is_json_number(trim(value.raw_json_token()))) {
    return wrong(value, place, expected);
  }
  if (!integer || count > rules_.max_hits) {
    return fail(ErrorKind::kInvalid, "NUMBER_OUT_OF_RANGE", "expected " + expected, place);
  }
  query_.max_hits = count;
  return true;
}

bool RayReader::read_crossings(od::value value) {
  const JsonPointer place = JsonPointer().key("crossings");
  std::string_view name;
  if (const auto code = value.get_string().get(name); code != simdjson::SUCCESS) {
    if (code == simdjson::INCORRECT_TYPE) return wrong(value, place, "\"every\" or \"once\"");
    return malformed(place, "this is not a valid string");
  }
  if (name != "every" && name != "once") {
    return fail(ErrorKind::kInvalid, "VALUE_UNKNOWN", "expected \"every\" or \"once\"", place);
  }
  query_.crossings = name == "once" ? Crossings::kOnce : Crossings::kEvery;
  return true;
}

unsigned RayReader::known_top_keys() const {
  unsigned known = kRaysBit | kColumnBits;
  if (rules_.has_fields) known |= kFieldsBit;
  if (rules_.has_max_hits) known |= kMaxHitsBit;
  if (rules_.has_crossings) known |= kCrossingsBit;
  return known;
}

bool RayReader::read_top(od::object object) {
  const unsigned known = known_top_keys();
  for (auto entry : object) {
    od::field field;
    if (const auto code = std::move(entry).get(field); code != simdjson::SUCCESS) {
      return check_end(code, [] { return JsonPointer(); });
    }
    std::size_t which = 0;
    if (!read_key(field, kTopKeys, known, JsonPointer(), which)) return false;
    const unsigned bit = 1u << which;
    const JsonPointer place = JsonPointer().key(kTopKeys[which]);
    if (!mark_seen(bit, seen_, place)) return false;
    if ((seen_ & kRaysBit) != 0 && (seen_ & kColumnBits) != 0) {
      return fail(ErrorKind::kInvalid, "KEYS_MIXED",
                  "rays come as rows (\"rays\") or as columns (\"origins\", \"directions\"), not "
                  "as both",
                  place);
    }
    const od::value value = field.value();
    const bool good = bit == kRaysBit        ? read_rows(value)
                      : bit == kFieldsBit    ? read_fields(value)
                      : bit == kMaxHitsBit   ? read_max_hits(value)
                      : bit == kCrossingsBit ? read_crossings(value)
                                             : read_column(value, static_cast<Part>(which - 1));
    if (!good) return false;
  }
  return true;
}

bool RayReader::finish_rows_or_columns() {
  if ((seen_ & kRaysBit) != 0) return true;
  query_.layout = AnswerLayout::kColumns;
  for (const Part part : {Part::kOrigin, Part::kDirection}) {
    if ((seen_ & (2u << static_cast<unsigned>(part))) == 0) {
      const std::string key(kColumnKeys[static_cast<std::size_t>(part)]);
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
                column_place(Part::kDirection));
  }
  for (const Part part : {Part::kTmin, Part::kTmax}) {
    Column<double>& column = part == Part::kTmin ? query_.rays.tmin : query_.rays.tmax;
    if ((seen_ & (2u << static_cast<unsigned>(part))) == 0) {
      if (part == Part::kTmin) {
        column.assign(count, 0.0);
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

bool RayReader::check_limits_and_directions() {
  RayFault fault;
  if (check_rays(query_.rays, fault)) return true;
  std::string_view part_name = fault.part;
  // A tmin of 0 may be the default: then what the client wrote is the tmax.
  if (part_name == "tmin" && query_.rays.tmin[fault.ray] == 0) part_name = "tmax";
  const auto part =
      static_cast<Part>(std::find(kRowKeys.begin(), kRowKeys.end(), part_name) - kRowKeys.begin());
  const bool vector = part == Part::kOrigin || part == Part::kDirection;
  return fail(ErrorKind::kInvalid, fault.code, fault.message,
              query_.layout == AnswerLayout::kRows
                  ? row_place(fault.ray, part)
                  : column_place(part, vector ? fault.ray * 3 : fault.ray));
}

Result<RayQuery> RayReader::read(std::string& body) {
  // The on-demand front is compiled for any machine; its first stage, where the time goes, is
  // chosen at run time for this one.
  od::parser parser;
  static_assert(kRayJsonPadding >= simdjson::SIMDJSON_PADDING);
  body.reserve(body.size() + kRayJsonPadding);
  od::document document;
  if (const auto code = parser.iterate(body).get(document); code != simdjson::SUCCESS) {
    if (code == simdjson::CAPACITY) {
      return Error{ErrorKind::kTooLarge, "BODY_TOO_LARGE", "the body is too large for JSON", ""};
    }
    return Error{ErrorKind::kMalformed, "JSON_MALFORMED",
                 code == simdjson::EMPTY ? "the body is empty" : simdjson::error_message(code), ""};
  }
  od::object object;
  if (const auto code = document.get_object().get(object); code != simdjson::SUCCESS) {
    std::string_view token;
    if (code == simdjson::INCORRECT_TYPE && document.raw_json_token().get(token) == 0 &&
        looks_like_json(trim(token))) {
      return Error{ErrorKind::kInvalid, "TYPE_WRONG", "expected an object as the whole body", ""};
    }
    return Error{
        ErrorKind::kMalformed, "JSON_MALFORMED",
        code == simdjson::INCORRECT_TYPE ? "this is not JSON" : simdjson::error_message(code), ""};
  }
  if (!read_top(object)) return error_;
  if (document.current_location().error() != simdjson::OUT_OF_BOUNDS) {
    return Error{ErrorKind::kMalformed, "JSON_MALFORMED", "there is text after the body's object",
                 ""};
  }
  if (!finish_rows_or_columns() || !check_limits_and_directions()) return error_;
  return std::move(query_);
}

}  // namespace

Result<RayQuery> decode_rays(std::string& body, const RayJsonRules& rules) {
  return RayReader(rules).read(body);
}

}  // namespace sightline
