#include "proto/binary/hit_binary.h"

#include <algorithm>
#include <array>

#include "proto/binary/binary_answer.h"
#include "proto/binary/ray_binary.h"
#include "proto/hit_columns.h"

namespace sightline {
namespace {

/// As docs/reference/binary.md numbers them.
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

/// Announces a column of this name and number of rows; texts have none.
struct ColumnEntry {
  BinaryAnswer& answer;
  std::string_view name;
  std::size_t rows;

  void operator()(const NumberColumn&) const { answer.announce<double>(name, rows); }
  template <std::size_t width, class Value>
  void operator()(const VectorColumn<width, Value>&) const {
    answer.announce<double>(name, rows, width);
  }
  void operator()(const IdColumn&) const { answer.announce<std::uint32_t>(name, rows); }
  template <class Value>
  void operator()(const FlagColumn<Value>&) const {
    answer.announce<std::uint8_t>(name, rows);
  }
  void operator()(const NameColumn&) const {}
};

/// Writes it.
struct ColumnBytes {
  BinaryAnswer& answer;
  const HitBatch& hits;

  void operator()(const NumberColumn& column) const { answer.next(column.numbers); }
  template <std::size_t width, class Value>
  void operator()(const VectorColumn<width, Value>& column) const {
    answer.next<double>([&](std::size_t i, std::uint32_t k) {
      return hits.hit(i) ? column.value(i, k) : kNoNumber;
    });
  }
  void operator()(const IdColumn& column) const { answer.next(column.ids); }
  template <class Value>
  void operator()(const FlagColumn<Value>& column) const {
    answer.next<std::uint8_t>([&](std::size_t i, std::uint32_t) {
      return hits.hit(i) ? (column.value(i) ? 1 : 0) : 255;
    });
  }
  void operator()(const NameColumn&) const {}
};

void announce_all(BinaryAnswer& answer, const HitAnswer& hits, FieldSet fields) {
  visit_columns(hits, fields, [&](std::string_view name, const auto& column) {
    ColumnEntry{answer, name, hits.hits.size()}(column);
  });
}

void write_all(BinaryAnswer& answer, const HitAnswer& hits, FieldSet fields) {
  visit_columns(hits, fields, [&](std::string_view, const auto& column) {
    ColumnBytes{answer, hits.hits}(column);
  });
}

/// The answer of one column, one number for each ray.
template <class Number>
std::string encode_one(std::string_view name, std::span<const Number> values,
                       const InvalidRays* invalid) {
  BinaryAnswer answer;
  answer.announce<Number>(name, values.size());
  if (invalid != nullptr) answer.announce<std::uint8_t>("invalid", values.size());
  answer.begin();
  answer.next(values);
  if (invalid != nullptr) write_invalid(answer, *invalid);
  return answer.take();
}

}  // namespace

Status check_binary_fields(FieldSet fields, std::span<const std::string> named) {
  for (const HitField field : all_hit_fields()) {
    if (!fields.has(field) || !kTextFields.has(field)) continue;
    return Error{ErrorKind::kInvalid, "FIELD_IS_TEXT",
                 "a binary answer has no texts: ask for ids instead of \"" +
                     std::string(hit_field_name(field)) + "\"",
                 "/fields"};
  }
  for (const std::string& name : named) {
    if (name.size() <= BinaryAnswer::kLongestName) continue;
    return Error{ErrorKind::kInvalid, "FIELD_NAME_LONG",
                 "names of binary columns have at most " +
                     std::to_string(BinaryAnswer::kLongestName) + " bytes: ask for \"" + name +
                     "\" as JSON, or of rays:closest as CSV, NPY or NPZ",
                 "/fields"};
  }
  return success();
}

std::string encode_hits_binary(const HitBatch& hits, std::span<const HitDetail> details,
                               const HitTerms& terms, FieldSet fields, const InvalidRays* invalid) {
  const HitAnswer columns{hits, details, terms};
  BinaryAnswer answer;
  announce_all(answer, columns, fields);
  if (invalid != nullptr) answer.announce<std::uint8_t>("invalid", hits.size());
  answer.begin();
  write_all(answer, columns, fields);
  if (invalid != nullptr) write_invalid(answer, *invalid);
  return answer.take();
}

std::string encode_hit_lists_binary(const HitLists& lists, std::span<const std::uint64_t> totals,
                                    std::span<const HitDetail> details, const HitTerms& terms,
                                    FieldSet fields, const InvalidRays* invalid) {
  const HitAnswer columns{lists.hits, details, terms};
  BinaryAnswer answer;
  answer.announce<std::uint64_t>("totals", totals.size());
  answer.announce<std::uint64_t>("first", lists.first.size());
  announce_all(answer, columns, fields);
  if (invalid != nullptr) answer.announce<std::uint8_t>("invalid", totals.size());
  answer.begin();
  answer.next(totals);
  answer.next(std::span<const std::uint64_t>(lists.first));
  write_all(answer, columns, fields);
  if (invalid != nullptr) write_invalid(answer, *invalid);
  return answer.take();
}

std::string encode_nearest_lists_binary(const HitLists& lists, std::span<const HitDetail> details,
                                        const HitTerms& terms, FieldSet fields) {
  const HitAnswer columns{lists.hits, details, terms};
  BinaryAnswer answer;
  answer.announce<std::uint64_t>("first", lists.first.size());
  announce_all(answer, columns, fields);
  answer.begin();
  answer.next(std::span<const std::uint64_t>(lists.first));
  write_all(answer, columns, fields);
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
