#include "proto/hit_binary.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <vector>

#include "proto/ray_binary.h"

namespace sightline {
namespace {

static_assert(std::endian::native == std::endian::little, "columns are copied as they stand");

constexpr std::size_t kHeaderBytes = 16, kEntryBytes = 40, kNameBytes = 16;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

template <class Number>
constexpr std::uint32_t kTypeOf = 0;
template <>
constexpr std::uint32_t kTypeOf<double> = 1;
template <>
constexpr std::uint32_t kTypeOf<std::uint32_t> = 2;
template <>
constexpr std::uint32_t kTypeOf<std::uint8_t> = 3;
template <>
constexpr std::uint32_t kTypeOf<std::uint64_t> = 4;

/// Collects columns, then writes them behind their table. The memory of an answer is its bytes
/// once: columns are announced first and filled in place.
class BinaryAnswer {
 public:
  void announce(std::string_view name, std::uint32_t type, std::size_t number_bytes,
                std::uint32_t width, std::size_t rows) {
    entries_.push_back({name, type, number_bytes, width, rows});
  }

  /// After this, `next` in the order of the announcements.
  void begin() {
    std::size_t size = kHeaderBytes + entries_.size() * kEntryBytes;
    for (Entry& entry : entries_) {
      entry.at = size;
      size += (entry.rows * entry.width * entry.number_bytes + 7) / 8 * 8;
    }
    text_.assign(size, '\0');
    std::memcpy(text_.data(), "SLA1", 4);
    write(4, static_cast<std::uint32_t>(entries_.size()));
    std::size_t at = kHeaderBytes;
    for (const Entry& entry : entries_) {
      std::memcpy(text_.data() + at, entry.name.data(), std::min(entry.name.size(), kNameBytes));
      write(at + 16, entry.type);
      write(at + 20, entry.width);
      write(at + 24, std::uint64_t{entry.at});
      write(at + 32, std::uint64_t{entry.rows});
      at += kEntryBytes;
    }
  }

  /// value(row, component) of the next column.
  template <class Number, class Value>
  void next(Value value) {
    const Entry& entry = entries_[next_++];
    std::size_t at = entry.at;
    for (std::size_t row = 0; row < entry.rows; ++row) {
      for (std::uint32_t k = 0; k < entry.width; ++k) {
        write(at, static_cast<Number>(value(row, k)));
        at += sizeof(Number);
      }
    }
  }

  std::string take() { return std::move(text_); }

 private:
  struct Entry {
    std::string_view name;
    std::uint32_t type;
    std::size_t number_bytes;
    std::uint32_t width;
    std::size_t rows;
    std::size_t at = 0;
  };
  template <class Number>
  void write(std::size_t at, Number number) {
    std::memcpy(text_.data() + at, &number, sizeof(Number));
  }

  std::vector<Entry> entries_;
  std::size_t next_ = 0;
  std::string text_;
};

template <class Number>
void announce(BinaryAnswer& answer, std::string_view name, std::size_t rows,
              std::uint32_t width = 1) {
  answer.announce(name, kTypeOf<Number>, sizeof(Number), width, rows);
}

/// As BINARY.md numbers them.
std::uint8_t fault_number(std::string_view code) {
  constexpr std::array<std::string_view, 4> kCodes{"RAY_NOT_FINITE", "RAY_DIRECTION_ZERO",
                                                   "RAY_LIMIT_NAN", "RAY_LIMITS_REVERSED"};
  const auto found = std::find(kCodes.begin(), kCodes.end(), code);
  return static_cast<std::uint8_t>(found - kCodes.begin() + 1);
}

void write_invalid(BinaryAnswer& answer, const InvalidRays& invalid) {
  std::size_t seen = 0;
  answer.next<std::uint8_t>([&](std::size_t ray, std::uint32_t) -> std::uint8_t {
    if (seen == invalid.number.size() || invalid.number[seen] != ray) return 0;
    return fault_number(invalid.code[seen++]);
  });
}

/// The numbers of one column of a hit, or what says "nothing".
struct HitColumns {
  const HitBatch& hits;
  std::span<const HitDetail> details;
  const HitTerms& terms;
  FieldSet fields;

  template <class Visit>
  void each(Visit visit) const {
    for (const HitField field : all_hit_fields()) {
      if (fields.has(field) && !kTextFields.has(field)) visit(field);
    }
  }
  void announce_all(BinaryAnswer& answer) const {
    each([&](HitField field) {
      const std::string_view name = hit_field_name(field);
      switch (field) {
        case HitField::kT:
        case HitField::kDistance:
          return announce<double>(answer, name, hits.size());
        case HitField::kPosition:
        case HitField::kNormal:
          return announce<double>(answer, name, hits.size(), 3);
        case HitField::kBarycentrics:
          return announce<double>(answer, name, hits.size(), 2);
        case HitField::kFront:
        case HitField::kOnEdge:
          return announce<std::uint8_t>(answer, name, hits.size());
        default:
          return announce<std::uint32_t>(answer, name, hits.size());
      }
    });
  }
  void write_all(BinaryAnswer& answer) const {
    each([&](HitField field) { write(answer, field); });
  }

 private:
  template <class Value>
  void numbers(BinaryAnswer& answer, Value value) const {
    answer.next<double>([&](std::size_t i, std::uint32_t k) {
      return hits.hit(i) ? value(details[i], static_cast<int>(k)) : kNan;
    });
  }
  template <class Value>
  void flags(BinaryAnswer& answer, Value value) const {
    answer.next<std::uint8_t>([&](std::size_t i, std::uint32_t) {
      return hits.hit(i) ? (value(details[i]) ? 1 : 0) : 255;
    });
  }
  void ids(BinaryAnswer& answer, const Column<std::uint32_t>& column) const {
    answer.next<std::uint32_t>([&](std::size_t i, std::uint32_t) { return column[i]; });
  }
  void write(BinaryAnswer& answer, HitField field) const {
    switch (field) {
      case HitField::kT:
        return answer.next<double>([&](std::size_t i, std::uint32_t) {
          return terms.t_is_distance ? terms.distance[i] : hits.t[i];
        });
      case HitField::kDistance:
        return answer.next<double>([&](std::size_t i, std::uint32_t) { return terms.distance[i]; });
      case HitField::kPosition:
        return numbers(answer, [](const HitDetail& d, int k) { return d.position[k]; });
      case HitField::kNormal:
        return numbers(answer, [](const HitDetail& d, int k) { return d.normal[k]; });
      case HitField::kBarycentrics:
        return numbers(answer, [](const HitDetail& d, int k) { return k == 0 ? d.u : d.v; });
      case HitField::kFront:
        return flags(answer, [](const HitDetail& d) { return d.front; });
      case HitField::kOnEdge:
        return flags(answer, [](const HitDetail& d) { return d.on_edge; });
      case HitField::kInstance:
        return ids(answer, hits.instance);
      case HitField::kPrimitive:
        return ids(answer, terms.primitive);
      case HitField::kTriangle:
        return ids(answer, terms.triangle);
      case HitField::kNodeId:
        return ids(answer, terms.node);
      case HitField::kMeshId:
        return ids(answer, terms.mesh);
      case HitField::kMaterialId:
        return ids(answer, terms.material);
      case HitField::kNode:
      case HitField::kNodePath:
      case HitField::kMesh:
      case HitField::kMaterial:
        return;  // texts
    }
  }
};

/// The answer of one column, one number for each ray.
template <class Number, class Source>
std::string encode_one(std::string_view name, std::span<const Source> values,
                       const InvalidRays* invalid) {
  BinaryAnswer answer;
  announce<Number>(answer, name, values.size());
  if (invalid != nullptr) announce<std::uint8_t>(answer, "invalid", values.size());
  answer.begin();
  answer.next<Number>([&](std::size_t i, std::uint32_t) { return values[i]; });
  if (invalid != nullptr) write_invalid(answer, *invalid);
  return answer.take();
}

}  // namespace

Status check_binary_fields(FieldSet fields) {
  for (const HitField field : all_hit_fields()) {
    if (!fields.has(field) || !kTextFields.has(field)) continue;
    return Error{ErrorKind::kInvalid, "FIELD_IS_TEXT",
                 "a binary answer has no texts: ask for ids instead of \"" +
                     std::string(hit_field_name(field)) + "\"",
                 "/fields"};
  }
  return success();
}

std::string encode_hits_binary(const HitBatch& hits, std::span<const HitDetail> details,
                               const HitTerms& terms, FieldSet fields, const InvalidRays* invalid) {
  const HitColumns columns{hits, details, terms, fields};
  BinaryAnswer answer;
  columns.announce_all(answer);
  if (invalid != nullptr) announce<std::uint8_t>(answer, "invalid", hits.size());
  answer.begin();
  columns.write_all(answer);
  if (invalid != nullptr) write_invalid(answer, *invalid);
  return answer.take();
}

std::string encode_hit_lists_binary(const HitLists& lists, std::span<const std::uint64_t> totals,
                                    std::span<const HitDetail> details, const HitTerms& terms,
                                    FieldSet fields, const InvalidRays* invalid) {
  const HitColumns columns{lists.hits, details, terms, fields};
  BinaryAnswer answer;
  announce<std::uint64_t>(answer, "totals", totals.size());
  announce<std::uint64_t>(answer, "first", lists.first.size());
  columns.announce_all(answer);
  if (invalid != nullptr) announce<std::uint8_t>(answer, "invalid", totals.size());
  answer.begin();
  answer.next<std::uint64_t>([&](std::size_t i, std::uint32_t) { return totals[i]; });
  answer.next<std::uint64_t>([&](std::size_t i, std::uint32_t) { return lists.first[i]; });
  columns.write_all(answer);
  if (invalid != nullptr) write_invalid(answer, *invalid);
  return answer.take();
}

std::string encode_counts_binary(std::span<const std::uint64_t> counts,
                                 const InvalidRays* invalid) {
  return encode_one<std::uint64_t>("counts", counts, invalid);
}

std::string encode_occlusion_binary(std::span<const std::uint8_t> occluded,
                                    const InvalidRays* invalid) {
  return encode_one<std::uint8_t>("hits", occluded, invalid);
}

}  // namespace sightline
