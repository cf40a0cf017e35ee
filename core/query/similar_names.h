#pragma once
/// Suggests names that a client may have meant by a pattern that matches no name.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "core/base/watch.h"

namespace sightline {

/// Returns at most three different names, nearest first; names at equal distance are in the order
/// of `name_at`. The distance is the number of bytes to insert, delete or replace until the pattern
/// matches the name, ignoring the case of ASCII letters. Names whose distance exceeds a third of
/// the pattern's length (rounded) are not suggested. A name that contains a pattern without
/// wildcards has distance one. Names above 64 bytes are not suggested.
/// names     number of names; name_at(i) returns name i
/// Cost: at most `most_steps` steps of some nanoseconds; names that remain are not examined. Ends
/// early if the deadline of `watch` passes.
std::vector<std::string_view> similar_names(
    std::string_view pattern, std::size_t names,
    const std::function<std::string_view(std::size_t)>& name_at, std::uint64_t most_steps,
    DeadlineWatch& watch);

}  // namespace sightline
