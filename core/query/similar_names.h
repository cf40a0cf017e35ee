#pragma once
/// Names that a client may have meant by a pattern that matches none.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "core/base/watch.h"

namespace sightline {

/// Returns at most three different names, nearest first; at equal distance in their order in
/// `names`. The distance is the number of bytes to insert, delete or replace until the pattern
/// matches, ignoring the case of ASCII letters. It is at most a third of the pattern's bytes,
/// rounded. A name that contains a pattern without wildcards has distance one. Names above 64 bytes
/// are not suggested. Cost: at most `most_steps` steps of some nanoseconds; names that are left
/// then are not examined. Ends early where the watch has passed.
std::vector<std::string_view> similar_names(
    std::string_view pattern, std::size_t names,
    const std::function<std::string_view(std::size_t)>& name_at, std::uint64_t most_steps,
    DeadlineWatch& watch);

}  // namespace sightline
