#pragma once
/// The cursor of a list that continues: a text that a client returns as it received it.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sightline {

struct ListCursor {
  std::uint64_t revision = 0;  ///< of the scene that was asked
  std::uint64_t question = 0;  ///< BoxQuery::questions: the shape and the mode
  bool of_nodes = false;
  std::uint64_t from = 0;  ///< list_place (core/query/box_answers.h); 0: no cursor
};

std::string encode_cursor(const ListCursor& cursor);
/// Empty for a text that encode_cursor never made.
std::optional<ListCursor> decode_cursor(std::string_view text);

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
