#include "proto/json/clearance_json.h"

#include <array>

#include "core/base/infinity.h"
#include "proto/json/json_writer.h"
#include "proto/json/ray_reader.h"

namespace sightline {
namespace {

constexpr std::array<std::string_view, 5> kClearanceKeys{"a", "b", "max_distance", "pairs",
                                                         "limit"};

class ClearanceReader : public RayReader {
 public:
  explicit ClearanceReader(std::uint64_t max_limit)
      : RayReader(
            {.has_fields = false, .has_rays = false, .has_marks = false, .has_culling = false}),
        max_limit_(max_limit) {}

  Result<ClearanceQuery> read_all(std::string& body) {
    Result<RayQuery> options = read(body);
    if (!options) return std::move(options).error();
    result_.options = std::move(*options);
    result_.a = std::move(*a_);
    result_.b = std::move(*b_);
    return std::move(result_);
  }

 private:
  std::span<const std::string_view> more_keys() const override { return kClearanceKeys; }

  bool read_more(std::size_t which, Value value) override {
    const JsonPointer place = JsonPointer().key(kClearanceKeys[which]);
    ClearanceQuestion& question = result_.question;
    if (which < 2) return read_choice(kClearanceKeys[which], value, which == 0 ? a_ : b_);
    if (which == 2) {
      if (!read_number_or_null(value, kInf, question.max_distance,
                               [&] { return JsonPointer(place); })) {
        return false;
      }
      return question.max_distance >= 0 ||
             invalid("DISTANCE_NEGATIVE", "a distance must not be negative", place);
    }
    if (which == 4) return read_count(value, max_limit_, question.limit, place);
    constexpr std::array<std::string_view, 3> kPairs{"closest", "triangles", "nodes"};
    constexpr std::array<ClearancePairs, 3> kMeant{
        ClearancePairs::kClosest, ClearancePairs::kTriangles, ClearancePairs::kNodes};
    std::size_t word = 0;
    if (!read_word(value, kPairs, word, place)) return false;
    question.pairs = kMeant[word];
    return true;
  }

  bool finish_more() override {
    if (!a_ || !b_) {
      return invalid("KEY_MISSING", std::string("needs \"") + (a_ ? "b" : "a") + "\"", {});
    }
    return result_.question.pairs == ClearancePairs::kClosest ||
           result_.question.max_distance < kInf ||
           invalid("DISTANCE_MISSING", "all pairs are asked for within a \"max_distance\"",
                   JsonPointer().key("pairs"));
  }

  std::uint64_t max_limit_;
  std::optional<TriangleChoice> a_, b_;
  ClearanceQuery result_;
};

void write_end(JsonWriter& out, const TriangleId& id, const Vec3d& at, const HitTerms& terms,
               std::size_t i) {
  out.raw('{');
  write_triangle_members(out, id.instance, terms, i);
  out.raw(",\"position\":");
  out.vector(at.x, at.y, at.z);
  out.raw('}');
}

}  // namespace

Result<ClearanceQuery> decode_clearance(std::string& body, std::uint64_t max_limit) {
  return ClearanceReader(max_limit).read_all(body);
}

std::string encode_clearance(const ClearanceAnswer& answer, ClearancePairs pairs, const HitTerms& a,
                             const HitTerms& b) {
  JsonWriter out(64 + answer.pairs.size() * 256);
  const bool is_list = pairs != ClearancePairs::kClosest;
  if (is_list) {
    out.raw("{\"total\":");
    out.number(answer.total);
    out.raw(",\"pairs\":[");
  } else {
    out.raw("{\"pair\":");
    if (answer.pairs.empty()) out.raw("null");
  }
  for (std::size_t i = 0; i < answer.pairs.size(); ++i) {
    const ClearancePair& pair = answer.pairs[i];
    out.raw(i > 0 ? ",{\"distance\":" : "{\"distance\":");
    out.number(pair.distance);
    out.raw(",\"a\":");
    write_end(out, pair.a, pair.on_a, a, i);
    out.raw(",\"b\":");
    write_end(out, pair.b, pair.on_b, b, i);
    out.raw('}');
  }
  out.raw(is_list ? "]}" : "}");
  return out.take();
}

}  // namespace sightline
