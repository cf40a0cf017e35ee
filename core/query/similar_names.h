#pragma once
/// Suggests names that a client may have meant by a pattern that matches no name.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/watch.h"

namespace sightline {

/// Returns at most three different names that resemble a pattern with * and ? (hit_filter.h),
/// nearest first; names at equal distance are in the order of `name_at`. The distance is the number
/// of edits until the pattern matches the name, ignoring the case of ASCII letters: bytes that are
/// inserted, deleted or replaced, and neighbours that are exchanged. A name that contains a pattern
/// without wildcards has distance one. Let n be the number of bytes of the pattern without its stars. Names whose distance exceeds n / 3 (rounded,
/// at least 1) are not suggested, nor names above 64 bytes, nor any name if n < 2.
/// names       number of names; name_at(i) returns name i for i < names
/// most_steps  the cost: at most about so many steps of some nanoseconds; names that remain are not
///             examined
/// watch       the search ends early if the deadline passes, with the names found so far
/// The result refers to the memory that name_at returned. Throws std::bad_alloc.
std::vector<std::string_view> similar_names(
    std::string_view pattern, std::size_t names,
    const std::function<std::string_view(std::size_t)>& name_at, std::uint64_t most_steps,
    DeadlineWatch& watch);

/// The result of similar_names as the end of an error message: `; similar: "house 1", "house 2"`.
/// Empty if there are none.
std::string similar_names_text(std::string_view pattern, std::size_t names,
                               const std::function<std::string_view(std::size_t)>& name_at,
                               std::uint64_t most_steps, DeadlineWatch& watch);

}  // namespace sightline
