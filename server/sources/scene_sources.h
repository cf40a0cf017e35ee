#pragma once
/// Sources of scenes other than request bodies: files below a folder, and URLs.

#include <cstdint>
#include <memory>
#include <optional>

#include "core/store/scene_store.h"
#include "proto/json/load_json.h"
#include "server/sources/scene_root.h"
#include "server/sources/url_fetch.h"

namespace sightline {

/// What clients may name. By default nothing is allowed.
struct SourceRules {
  std::optional<SceneRoot> root;  ///< folder of paths; empty: paths are not allowed
  UrlRules urls;
};

/// Returns a function that fetches the source of a request. What can be checked at once is checked
/// before. The function may be called later on any thread, and shares `rules`, which is not null.
/// Errors, with a pointer: PATH_NOT_ALLOWED, URL_NOT_ALLOWED, URL_INVALID, those of
/// SceneRoot::open_file.
/// limit  the most bytes of the source with all of its files
Result<SceneFetch> fetch_of(const LoadRequest& request,
                            const std::shared_ptr<const SourceRules>& rules, std::uint64_t limit);

}  // namespace sightline

// Tests: tests/integration/sources_test.py
