#include "proto/json/clearance_json.h"

#include <array>

#include "core/base/infinity.h"
#include "proto/json/hit_rows.h"
#include "proto/json/json_parts.h"
#include "proto/json/ray_reader.h"

namespace sightline {
namespace {

constexpr std::array<std::string_view, 8> kClearanceKeys{"a",     "b",    "max_distance", "pairs",
                                                         "limit", "self", "adjacent",     "kinds"};

class ClearanceReader : public RayReader {
 public:
  explicit ClearanceReader(std::uint64_t max_limit)
      : RayReader({.has_rays = false,
                   .default_fields = kDefaultEndFields,
                   .known_fields = kEndFields,
                   .has_marks = false,
                   .has_culling = false,
                   .has_triangles = false}),
        max_limit_(max_limit) {}

  Result<ClearanceQuery> read_all(std::string& body) {
    Result<QueryOptions> options = read_options(body);
    if (!options) return std::move(options).error();
    result_.options = std::move(*options);
    for (std::size_t i = 0; i < 2; ++i) result_.sides[i].choice = std::move(*choices_[i]);
    return std::move(result_);
  }

 private:
  std::span<const std::string_view> more_keys() const override { return kClearanceKeys; }

  bool read_more(std::size_t which, Value value) override {
    const JsonPointer place = JsonPointer().key(kClearanceKeys[which]);
    ClearanceQuestion& question = result_.question;
    if (which < 2) {
      return read_choice(place, value, choices_[which], &result_.sides[which].exclude);
    }
    if (which == 2) {
      if (!read_number_or_null(value, kInf, question.max_distance,
                               [&] { return JsonPointer(place); })) {
        return false;
      }
      return question.max_distance >= 0 ||
             invalid("DISTANCE_NEGATIVE", "a distance must not be negative", place);
    }
    if (which == 4) return read_count(value, max_limit_, question.limit, place);
    if (which > 4) {
      bool* const flags[] = {&question.self, &question.adjacent, &question.kinds};
      return read_boolean(value, *flags[which - 5], place);
    }
    constexpr std::array<std::string_view, 3> kPairs{"closest", "triangles", "nodes"};
    constexpr std::array<ClearancePairs, 3> kMeant{
        ClearancePairs::kClosest, ClearancePairs::kTriangles, ClearancePairs::kNodes};
    std::size_t word = 0;
    if (!read_word(value, kPairs, word, place)) return false;
    question.pairs = kMeant[word];
    return true;
  }

  bool finish_more() override {
    if (!choices_[0] || !choices_[1]) {
      return invalid("KEY_MISSING", std::string("needs \"") + (choices_[0] ? "b" : "a") + "\"", {});
    }
    if (result_.question.kinds && result_.question.pairs != ClearancePairs::kNodes) {
      return invalid("KEYS_MIXED", "only pairs of nodes have kinds: needs \"pairs\":\"nodes\"",
                     JsonPointer().key("kinds"));
    }
    return result_.question.pairs == ClearancePairs::kClosest ||
           result_.question.max_distance < kInf ||
           invalid("DISTANCE_MISSING", "all pairs are asked for within a \"max_distance\"",
                   JsonPointer().key("pairs"));
  }

  std::uint64_t max_limit_;
  std::array<std::optional<TriangleChoice>, 2> choices_;
  ClearanceQuery result_;
};

}  // namespace

Result<ClearanceQuery> decode_clearance(std::string& body, std::uint64_t max_limit) {
  return ClearanceReader(max_limit).read_all(body);
}

std::string_view clash_kind_name(ClashKind kind) {
  constexpr std::array<std::string_view, kClashKindCount> kNames{
      "duplicate", "a_in_b", "b_in_a", "crossing", "touching", "near", "apart"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::string encode_clearance(const ClearanceAnswer& answer, const ClearanceQuestion& question,
                             FieldSet fields, const ClearanceEnds& a, const ClearanceEnds& b) {
  JsonWriter out(512 + answer.pairs.size() * (96 + 2 * expected_hit_bytes(fields)));
  const bool is_list = question.pairs != ClearancePairs::kClosest;
  if (is_list) write(out, "{\"total\":", answer.total);
  if (question.kinds) {
    for (std::size_t i = 0; i < kClashKindCount; ++i) {
      write(out, i == 0 ? ",\"kinds\":{\"" : ",\"", clash_kind_name(static_cast<ClashKind>(i)),
            "\":", answer.kinds[i]);
    }
    out.raw('}');
  }
  out.raw(is_list ? ",\"pairs\":[" : "{\"pair\":");
  if (!is_list && answer.pairs.empty()) out.raw("null");
  for (std::size_t i = 0; i < answer.pairs.size(); ++i) {
    const ClearancePair& pair = answer.pairs[i];
    out.raw(i > 0 ? ",{" : "{");
    if (question.kinds) {
      write(out, "\"kind\":\"", clash_kind_name(pair.kind), "\",\"depth\":", pair.depth, ',');
    }
    write(out, "\"distance\":", pair.distance, ",\"a\":");
    write_row(out, {a.hits, a.details, a.terms}, fields, i);
    out.raw(",\"b\":");
    write_row(out, {b.hits, b.details, b.terms}, fields, i);
    out.raw('}');
  }
  out.raw(is_list ? "]}" : "}");
  return out.take();
}

}  // namespace sightline
