#pragma once
/// ListCursor: where a list continues. Clients receive it as a text, and return it unchanged.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sightline {

/// The contents of a cursor: where a list of triangles or nodes in a box continues.
struct ListCursor {
  std::uint64_t revision = 0;  ///< of the scene that was queried
  /// hash of the box and the mode: the element of BoxQuery::questions of the box that is continued
  std::uint64_t question = 0;
  bool of_nodes = false;  ///< the list has nodes; false: triangles
  /// place of the next item (list_place in core/query/box_answers.h); 0: no cursor
  std::uint64_t from = 0;
};

/// The text of a cursor: 49 characters of a-z and 0-9.
std::string encode_cursor(const ListCursor& cursor);
/// The cursor of a text. Empty if the text is not a result of encode_cursor, or of a cursor with
/// `from` 0.
std::optional<ListCursor> decode_cursor(std::string_view text);

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
