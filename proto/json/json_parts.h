#pragma once
/// Appends several parts of a JSON text in one call, and numbers of nodes and the like.

#include <cstdint>
#include <string_view>
#include <type_traits>

#include "core/query/hit_batch.h"
#include "proto/json/json_writer.h"

namespace sightline {

/// Writes the parts in order: text that is JSON already, numbers, booleans, and vectors as
/// "[x,y,z]".
template <class... Parts>
void write(JsonWriter& out, const Parts&... parts) {
  const auto one = [&](const auto& part) {
    using Part = std::decay_t<decltype(part)>;
    if constexpr (std::is_same_v<Part, bool>) {
      out.boolean(part);
    } else if constexpr (std::is_same_v<Part, char>) {
      out.raw(part);
    } else if constexpr (std::is_arithmetic_v<Part>) {
      out.number(part);
    } else if constexpr (requires { part.x; }) {
      out.vector(part.x, part.y, part.z);
    } else {
      out.raw(std::string_view(part));
    }
  };
  (one(parts), ...);
}

/// Writes a number of a node, an instance or a material; null for kNone.
inline void write_id(JsonWriter& out, std::uint32_t id) {
  if (id == kNone) return out.raw("null");
  out.number(id);
}

}  // namespace sightline

// Tests: tests/unit/proto/json_writer_test.cpp
