// What a body says beside its rays.

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>

#include "core/query/attribute_name.h"
#include "proto/json/ray_reader.h"

namespace sightline {
namespace {

/// A pattern is tried on every name of a scene: few and short ones.
constexpr std::size_t kMostPatterns = 64, kLongestPattern = 256;
constexpr std::size_t kMostNodes = 100'000;
/// Each is resolved for the whole scene.
constexpr std::size_t kMostFilters = 256;

std::string names_of(FieldSet fields) {
  std::string list;
  for (const HitField field : all_hit_fields()) {
    if (!fields.has(field)) continue;
    list += (list.empty() ? "" : ", ") + std::string(hit_field_name(field));
  }
  return list;
}

}  // namespace

Status check_filters(const RayQuery& query) {
  if (query.ray_filters.empty() || query.filter_of.size() == query.ray_count()) return success();
  return Error{ErrorKind::kInvalid, "LENGTH_WRONG",
               "has " + std::to_string(query.filter_of.size()) + " numbers for " +
                   std::to_string(query.ray_count()) + " rays",
               "/filters/rays"};
}

bool RayReader::read_fields(Value value) {
  const JsonPointer place = JsonPointer().key("fields");
  Array array;
  if (value.get_array().get(array) != simdjson::SUCCESS) {
    return wrong(value, place, "an array of names");
  }
  FieldSet fields;
  std::vector<std::string> named;
  std::size_t count = 0;
  for (auto element : array) {
    Value entry;
    if (const auto code = element.get(entry); code != simdjson::SUCCESS) {
      return check_end(code, [] { return JsonPointer().key("fields"); });
    }
    const JsonPointer entry_place = JsonPointer(place).index(count++);
    std::string_view name;
    if (const auto code = entry.get_string().get(name); code != simdjson::SUCCESS) {
      if (code == simdjson::INCORRECT_TYPE) return wrong(entry, entry_place, "a name");
      return malformed(entry_place, "this is not a valid string");
    }
    const bool is_named = is_attribute_name(name);
    const auto field = is_named ? HitField::kNamed : find_hit_field(name);
    if (!field || !rules_.known_fields.has(*field)) {
      return fail(ErrorKind::kInvalid, "FIELD_UNKNOWN",
                  "unknown field \"" + std::string(cut_utf8(name, 64)) +
                      "\"; known: " + names_of(rules_.known_fields),
                  entry_place);
    }
    if (is_named ? std::find(named.begin(), named.end(), name) != named.end()
                 : fields.has(*field)) {
      return fail(ErrorKind::kInvalid, "FIELD_DUPLICATE", "this field is asked for twice",
                  entry_place);
    }
    if (is_named && named.size() == kMostNamedFields) {
      return fail(
          ErrorKind::kTooLarge, "FIELDS_TOO_MANY",
          "a request may have " + std::to_string(kMostNamedFields) + " fields of the file's own",
          entry_place);
    }
    if (is_named) named.emplace_back(name);
    fields.add(*field);
  }
  if (fields.empty()) {
    return fail(ErrorKind::kInvalid, "FIELDS_EMPTY",
                "leave \"fields\" out, or name some of: " + names_of(rules_.known_fields), place);
  }
  query_.fields = fields;
  query_.named_fields = std::move(named);
  query_.chose_fields = true;
  return true;
}

bool RayReader::read_max_hits(Value value) {
  return read_count(value, rules_.max_hits, query_.max_hits, JsonPointer().key("max_hits"));
}

bool RayReader::read_crossings(Value value) {
  constexpr std::array<std::string_view, 2> kWords{"every", "once"};
  std::size_t which = 0;
  if (!read_word(value, kWords, which, JsonPointer().key("crossings"))) return false;
  query_.crossings = which == 1 ? Crossings::kOnce : Crossings::kEvery;
  return true;
}

bool RayReader::read_cull(Value value, const JsonPointer& place, HitFilter& filter) {
  constexpr std::array<std::string_view, 4> kWords{"none", "back", "front", "material"};
  std::size_t which = 0;
  if (!read_word(value, kWords, which, JsonPointer(place))) return false;
  filter.culling = static_cast<Culling>(which);
  return true;
}

bool RayReader::read_mask(Value value, const JsonPointer& place, HitFilter& filter) {
  std::uint64_t mask = 0;
  if (!read_count(value, 0xffffffffu, mask, JsonPointer(place))) return false;
  filter.mask = static_cast<std::uint32_t>(mask);
  return true;
}

bool RayReader::read_filter(Value value, const JsonPointer& place, HitFilter& filter) {
  constexpr std::array<std::string_view, 4> kKeys{"cull", "include", "exclude", "mask"};
  unsigned seen = 0;
  const auto read_part = [&](std::size_t which, Value part, const JsonPointer& part_place) {
    if (which == 0) return read_cull(part, part_place, filter);
    if (which == 3) return read_mask(part, part_place, filter);
    return read_choice(part_place, part, which == 1 ? filter.include : filter.exclude);
  };
  return read_members(value, kKeys, rules_.has_culling ? 15u : 14u, place, seen, read_part);
}

bool RayReader::read_filters(Value value) {
  constexpr std::array<std::string_view, 2> kKeys{"list", "rays"};
  const JsonPointer place = JsonPointer().key("filters");
  const auto read_list = [&](Value list, const JsonPointer& part) {
    return read_array(list, "an array of filters", part, [&](std::size_t i, Value item) {
      const JsonPointer item_place = JsonPointer(part).index(i);
      if (i < kMostFilters) {
        return read_filter(item, item_place, query_.ray_filters.emplace_back());
      }
      return fail(ErrorKind::kTooLarge, "FILTER_TOO_LARGE",
                  "a request may have " + std::to_string(kMostFilters) + " filters", item_place);
    });
  };
  const auto read_numbers = [&](Value numbers, const JsonPointer& part) {
    return read_array(numbers, "an array of numbers", part, [&](std::size_t i, Value item) {
      const JsonPointer item_place = JsonPointer(part).index(i);
      if (i == rules_.max_rays) return too_many(item_place);
      std::uint64_t number = 0;
      if (!read_count(item, kMostFilters - 1, number, item_place)) return false;
      query_.filter_of.push_back(static_cast<std::uint32_t>(number));
      return true;
    });
  };
  unsigned seen = 0;
  const auto read_part = [&](std::size_t which, Value part, const JsonPointer& part_place) {
    return which == 0 ? read_list(part, part_place) : read_numbers(part, part_place);
  };
  if (!read_members(value, kKeys, 3u, place, seen, read_part)) return false;
  if (seen != 3 || query_.ray_filters.empty()) {
    return invalid("KEY_MISSING", "needs \"rays\" and a \"list\" with a filter", place);
  }
  const auto& numbers = query_.filter_of;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] < query_.ray_filters.size()) continue;
    return invalid("NUMBER_OUT_OF_RANGE", "the list has no filter of this number",
                   JsonPointer(place).key("rays").index(i));
  }
  return true;
}

bool RayReader::read_on_invalid(Value value) {
  constexpr std::array<std::string_view, 2> kWords{"refuse", "mark"};
  std::size_t which = 0;
  if (!read_word(value, kWords, which, JsonPointer().key("on_invalid"))) return false;
  query_.marks_invalid = which == 1;
  return true;
}

bool RayReader::read_image(Value value) {
  constexpr std::array<std::string_view, 6> kWords{"depth",  "node",         "normal",
                                                   "visits", "node_colours", "shaded"};
  std::size_t which = 0;
  if (!read_word(value, kWords, which, JsonPointer().key("image"))) return false;
  query_.image.emplace().of = static_cast<HitImage::Of>(which);
  return true;
}

bool RayReader::read_patterns(Value value, const JsonPointer& place,
                              std::vector<std::string>& patterns) {
  const auto read_one = [&](std::size_t i, Value entry) {
    const JsonPointer entry_place = JsonPointer(place).index(i);
    if (i == kMostPatterns) {
      return fail(ErrorKind::kTooLarge, "FILTER_TOO_LARGE",
                  "a list may hold " + std::to_string(kMostPatterns) + " patterns", entry_place);
    }
    std::string_view text;
    if (const auto code = entry.get_string().get(text); code != simdjson::SUCCESS) {
      if (code == simdjson::INCORRECT_TYPE) return wrong(entry, entry_place, "a pattern of names");
      return malformed(entry_place, "this is not a valid string");
    }
    if (text.size() > kLongestPattern) {
      return fail(ErrorKind::kTooLarge, "FILTER_TOO_LARGE",
                  "a pattern may have " + std::to_string(kLongestPattern) + " bytes, this has " +
                      std::to_string(text.size()),
                  entry_place);
    }
    patterns.emplace_back(text);
    return true;
  };
  return read_array(value, "an array of patterns", place, read_one);
}

bool RayReader::read_triangles(Value value, const JsonPointer& place,
                               std::vector<TriangleName>& triangles) {
  const auto read_triangle = [&](std::size_t i, Value item) {
    const JsonPointer item_place = JsonPointer(place).index(i);
    if (i == kMostNodes) {
      return fail(ErrorKind::kTooLarge, "FILTER_TOO_LARGE",
                  "a list may hold " + std::to_string(kMostNodes) + " triangles", item_place);
    }
    std::array<std::uint32_t, 3> name{};
    std::size_t count = 0;
    const auto read_number = [&](std::size_t k, Value number) {
      const JsonPointer number_place = JsonPointer(item_place).index(k);
      count = k + 1;
      std::uint64_t read = 0;
      if (k < name.size() && !read_count(number, kNone - 1, read, number_place)) return false;
      if (k < name.size()) name[k] = static_cast<std::uint32_t>(read);
      return true;
    };
    if (!read_array(item, "[instance, primitive, triangle]", item_place, read_number)) return false;
    if (count != name.size()) {
      return invalid("LENGTH_WRONG", "a triangle is [instance, primitive, triangle]", item_place);
    }
    triangles.push_back({name[0], name[1], name[2]});
    return true;
  };
  return read_array(value, "an array of triangles", place, read_triangle);
}

bool RayReader::read_choice(const JsonPointer& place, Value value,
                            std::optional<TriangleChoice>& choice,
                            std::optional<TriangleChoice>* without) {
  constexpr std::array<std::string_view, 5> kKeys{"nodes", "names", "materials", "triangles",
                                                  "exclude"};
  constexpr std::size_t kTriangles = 3, kExclude = 4;
  const unsigned known =
      7u | (rules_.has_triangles ? 1u << kTriangles : 0u) | (without ? 1u << kExclude : 0u);
  choice.emplace();
  const auto read_node = [&](std::size_t i, Value number, const JsonPointer& list) {
    const JsonPointer node_place = JsonPointer(list).index(i);
    if (i == kMostNodes) {
      return fail(ErrorKind::kTooLarge, "FILTER_TOO_LARGE",
                  "a list may hold " + std::to_string(kMostNodes) + " nodes", node_place);
    }
    std::uint64_t node = 0;
    if (!read_count(number, std::numeric_limits<std::uint32_t>::max(), node, node_place)) {
      return false;
    }
    choice->nodes->push_back(static_cast<std::uint32_t>(node));
    return true;
  };
  unsigned seen = 0;
  const auto read_part = [&](std::size_t which, Value part, const JsonPointer& part_place) {
    switch (which) {
      case 0:
        choice->nodes.emplace();
        return read_array(
            part, "an array of node ids", part_place,
            [&](std::size_t i, Value number) { return read_node(i, number, part_place); });
      case 1:
        return read_patterns(part, part_place, choice->names.emplace());
      case 2:
        return read_patterns(part, part_place, choice->materials.emplace());
      case kTriangles:
        return read_triangles(part, part_place, choice->triangles.emplace());
      default:
        return read_choice(part_place, part, *without);
    }
  };
  if (!read_members(value, kKeys, known, place, seen, read_part)) return false;
  if (seen == 0) {
    return invalid("KEY_MISSING",
                   rules_.has_triangles
                       ? "needs \"nodes\", \"names\", \"materials\" or \"triangles\""
                       : "needs \"nodes\", \"names\" or \"materials\"",
                   place);
  }
  return true;
}

bool RayReader::read_option(std::string_view key, Value value) {
  if (key == "fields") return read_fields(value);
  if (key == "max_hits") return read_max_hits(value);
  if (key == "crossings") return read_crossings(value);
  if (key == "normalize") return read_boolean(value, query_.normalize, JsonPointer().key(key));
  if (key == "cull") return read_cull(value, JsonPointer().key(key), query_.filter);
  if (key == "on_invalid") return read_on_invalid(value);
  if (key == "explain") {
    return read_boolean(value, query_.wants_explanation, JsonPointer().key(key));
  }
  if (key == "work") return read_boolean(value, query_.wants_work, JsonPointer().key(key));
  if (key == "strict") return read_boolean(value, query_.strict, JsonPointer().key(key));
  if (key == "timeout_ms") {
    return read_timeout(value, query_.timeout_ms, JsonPointer().key(key));
  }
  if (key == "threads") return read_threads(value, query_.threads, JsonPointer().key(key));
  if (key == "image") return read_image(value);
  if (key == "alpha") {
    constexpr std::array<std::string_view, 2> kWords{"opaque", "cutoff"};
    std::size_t which = 0;
    if (!read_word(value, kWords, which, JsonPointer().key(key))) return false;
    query_.alpha_cutoff = which == 1;
    return true;
  }
  if (key == "image_unit") {
    const auto place = [&] { return JsonPointer().key(key); };
    return read_number(value, image_unit_, place) &&
           (image_unit_ > 0 ||
            invalid("NUMBER_OUT_OF_RANGE", "expected a number above 0", place()));
  }
  if (key == "mask") return read_mask(value, JsonPointer().key(key), query_.filter);
  return read_choice(JsonPointer().key(key), value,
                     key == "include" ? query_.filter.include : query_.filter.exclude);
}

}  // namespace sightline
