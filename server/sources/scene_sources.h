#pragma once
/// Sources of scenes other than request bodies: files below one folder, and URLs.

#include <cstdint>
#include <memory>
#include <optional>

#include "core/store/scene_store.h"
#include "proto/json/load_json.h"
#include "server/sources/scene_root.h"
#include "server/sources/url_fetch.h"

namespace sightline {

/// Nothing is allowed unless an operator says so.
struct SourceRules {
  std::optional<SceneRoot> root;  ///< paths are below it; empty: no paths
  UrlRules urls;
};

/// How to get what the request asks for, after what can be said of it at once. Errors, with a
/// pointer: PATH_NOT_ALLOWED, URL_NOT_ALLOWED, URL_INVALID, those of SceneRoot::open_file.
Result<SceneFetch> fetch_of(const LoadRequest& request, std::shared_ptr<const SourceRules> rules,
                            std::uint64_t limit);

}  // namespace sightline
