#pragma once
/// Statistics of a scene as names and numbers, for /v1/scenes/{id}/stats and /metrics.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/store/stored_scene.h"

namespace sightline {

/// Names with their counts.
using NamedCounts = std::vector<std::pair<std::string, std::uint64_t>>;

// The names are always the same, in the same order.

/// Bytes of the files that the import and later queries have read, by their use.
NamedCounts touched_counts(const Scene& scene);
/// Parts of the files that the import has left out.
NamedCounts skipped_counts(const Scene& scene);
/// The numbers of TreeStats.
NamedCounts tree_counts(const Scene& scene);

/// Returns
/// {"id","revision","counts":{...},"bytes":{"files","touched","by_kind":{...}},"skipped":{...},
/// "trees":{...,"complete"}}. Precondition: the scene is ready.
std::string encode_stats(const StoredScene& scene);

}  // namespace sightline

// Tests: tests/integration/metrics_test.py
