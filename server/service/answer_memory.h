#pragma once
/// Upper estimates of the memory of answers, so that it can be reserved before it is allocated.

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/base/watch.h"
#include "proto/json/hit_json.h"
#include "server/service/hit_terms.h"

namespace sightline {

/// Bytes of a ray and of a hit as columns.
inline constexpr std::uint64_t kRayBytes = 64, kHitBytes = 16;
/// Bytes of a number as JSON, with its comma.
inline constexpr std::uint64_t kNumberBytes = 25;
/// Bytes of an explanation: a thousand boxes with the triangles of their leaves, as data and as
/// JSON.
inline constexpr std::uint64_t kExplanationBytes = 1 << 20;

/// Bytes that describe_hits allocates for `hits` hits; `named` of the fields are named by the file.
std::uint64_t bytes_of_description(std::uint64_t hits, FieldSet fields, std::size_t named = 0);
/// Bytes of the encoded answer for `hits` described hits.
std::uint64_t bytes_of_encoded(std::uint64_t hits, FieldSet fields, const HitTerms& terms);
/// Reserves memory, calls describe_hits, and reserves memory to encode the answer. `reserve` may be
/// null. Errors: those of `reserve` and of describe_hits; `about` is then unspecified.
Status describe_within(const ReserveBytes& reserve, const Engine& engine,
                       const DescribedHits& described, const Deadline& deadline,
                       HitDescription& about);
/// Bytes of names in an answer; each character may have to be escaped.
std::uint64_t bytes_of_names(std::span<const std::string_view> names);

/// Searches lists of unknown length. search(most) must find at most `most` entries in total, and
/// fail with ErrorKind::kTooLarge if there are more. It is called with a small number first, and
/// then, from the beginning, with larger ones as memory is granted, up to `most`. Errors: those of
/// `reserve` and of the last search.
/// lists        number of lists
/// entry_bytes  bytes of an entry
template <class Search>
Status search_lists(const ReserveBytes& reserve, std::uint64_t lists, std::uint64_t most,
                    std::uint64_t entry_bytes, const Search& search) {
  constexpr std::uint64_t kFirst = 16 << 10, kStep = 16;
  std::uint64_t reserved = 0, granted = std::min(most, kFirst);
  for (;;) {
    const std::uint64_t bytes = lists * 3 * sizeof(std::uint64_t) + granted * entry_bytes;
    if (Status status = ask_for(reserve, bytes - reserved); !status) return status;
    reserved = bytes;
    Status found = search(granted);
    if (found || found.error().kind != ErrorKind::kTooLarge || granted == most) return found;
    granted = granted > most / kStep ? most : granted * kStep;
  }
}

}  // namespace sightline

// Tests: tests/integration/memory_test.py
