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

/// Returns a function that fetches the source of a request, after it has checked what can be
/// checked at once. Errors, with a pointer: PATH_NOT_ALLOWED, URL_NOT_ALLOWED, URL_INVALID, those
/// of SceneRoot::open_file.
Result<SceneFetch> fetch_of(const LoadRequest& request, std::shared_ptr<const SourceRules> rules,
                            std::uint64_t limit);

}  // namespace sightline
