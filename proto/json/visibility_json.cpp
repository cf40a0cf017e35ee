#include "proto/json/visibility_json.h"

#include <array>

#include "proto/json/point_rows.h"
#include "proto/json/ray_reader.h"

namespace sightline {
namespace {

constexpr std::array<std::string_view, 5> kVisibilityKeys{"from", "to", "pairing", "ends",
                                                          "first_blocker"};

class VisibilityReader : public RayReader {
 public:
  explicit VisibilityReader(std::size_t max_pairs)
      : RayReader({.has_rays = false, .has_marks = false}), max_pairs_(max_pairs) {}

  Result<VisibilityQuery> read_all(std::string& body) {
    Result<QueryOptions> options = read_options(body);
    if (!options) return std::move(options).error();
    visibility_.options = std::move(*options);
    return std::move(visibility_);
  }

 private:
  std::span<const std::string_view> more_keys() const override { return kVisibilityKeys; }

  bool read_more(std::size_t which, Value value) override {
    seen_ |= 1u << which;
    PointPairs& pairs = visibility_.pairs;
    const JsonPointer place = JsonPointer().key(kVisibilityKeys[which]);
    if (which < 2) {
      return read_points(*this, value, place, max_pairs_, which == 0 ? pairs.from : pairs.to,
                         [&](const JsonPointer& point) { return too_many_points(point); });
    }
    if (which == 4) return read_boolean(value, visibility_.first_blocker, place);
    constexpr std::array<std::string_view, 2> kPairings{"each", "all"}, kEnds{"open", "closed"};
    std::size_t word = 0;
    if (!read_word(value, which == 2 ? kPairings : kEnds, word, place)) return false;
    if (which == 2) {
      pairs.pairing = word == 1 ? BoxPairing::kAll : BoxPairing::kEach;
    } else {
      pairs.closed = word == 1;
    }
    return true;
  }

  bool too_many_points(const JsonPointer& place) {
    return fail(ErrorKind::kTooLarge, "PAIRS_TOO_MANY",
                "a request may have " + std::to_string(max_pairs_) + " pairs", place);
  }

  bool finish_more() override {
    for (std::size_t which = 0; which < 2; ++which) {
      if ((seen_ >> which & 1u) == 0) {
        return invalid("KEY_MISSING", "needs \"" + std::string(kVisibilityKeys[which]) + "\"", {});
      }
    }
    const PointPairs& pairs = visibility_.pairs;
    const JsonPointer to = JsonPointer().key("to");
    if (pairs.pairing == BoxPairing::kEach && pairs.from.size() != pairs.to.size()) {
      return invalid("PAIRS_UNEQUAL",
                     "\"each\" needs as many points in both lists, has " +
                         std::to_string(pairs.from.size()) + " and " +
                         std::to_string(pairs.to.size()),
                     to);
    }
    if (!pairs.to.empty() && pairs.from.size() > max_pairs_ / pairs.to.size() &&
        pairs.pairing == BoxPairing::kAll) {
      return too_many_points(to);
    }
    if (query_.chose_fields && !visibility_.first_blocker) {
      return invalid("FIELDS_WITHOUT_BLOCKER", "fields are those of \"first_blocker\":true",
                     JsonPointer().key("fields"));
    }
    PairFault fault;
    if (check_pairs(pairs, fault)) return true;
    return invalid("POINTS_TOO_FAR",
                   "the difference to point " + std::to_string(fault.from) +
                       " of \"from\" overflows a float64",
                   JsonPointer(to).index(fault.to));
  }

  std::size_t max_pairs_;
  unsigned seen_ = 0;
  VisibilityQuery visibility_;
};

/// Calls write_pair(i) for the pairs of each row, in brackets of the row.
template <class WritePair>
void write_rows(const PointPairs& pairs, std::string& out, char open, char close,
                std::string_view comma, WritePair write_pair) {
  const bool all = pairs.pairing == BoxPairing::kAll;
  const std::size_t rows = all ? pairs.from.size() : 1;
  const std::size_t width = all ? pairs.to.size() : pairs.size();
  if (all) out += '[';
  for (std::size_t row = 0; row < rows; ++row) {
    if (row > 0) out += ',';
    out += open;
    for (std::size_t k = 0; k < width; ++k) {
      if (k > 0) out += comma;
      write_pair(row * width + k);
    }
    out += close;
  }
  if (all) out += ']';
}

}  // namespace

Result<VisibilityQuery> decode_visibility(std::string& body, std::size_t max_pairs) {
  return VisibilityReader(max_pairs).read_all(body);
}

std::string encode_visibility(const VisibilityQuery& query, std::span<const std::uint8_t> visible,
                              const HitBatch* blockers, std::span<const HitDetail> details,
                              const HitTerms& terms) {
  std::string out = "{\"visible\":";
  out.reserve(64 + visible.size() + 3 * query.pairs.from.size());
  write_rows(query.pairs, out, '"', '"', "", [&](std::size_t i) { out += visible[i] ? '1' : '0'; });
  if (blockers != nullptr) {
    out += ",\"blockers\":";
    write_rows(query.pairs, out, '[', ']', ",", [&](std::size_t i) {
      out += encode_hit(*blockers, details, terms, query.options.fields, i);
    });
  }
  out += '}';
  return out;
}

}  // namespace sightline
