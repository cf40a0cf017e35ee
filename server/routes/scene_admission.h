#pragma once
/// Admission of queries of a scene, before their bodies are read, and answers to changes of scenes.

#include <memory>
#include <string>

#include "core/scene/scene.h"
#include "server/http/exchange.h"
#include "server/service/service.h"

namespace sightline {

/// The scene, if it can be asked now. Null after it has answered: 404 SCENE_NOT_FOUND, 409
/// SCENE_FAILED or SCENE_LOADING (with Retry-After).
SceneSnapshot admit_scene(Exchange& exchange, const Service& service);

/// Its scene, and a body that may be read. Null after it has answered:
/// MEDIA_TYPE_UNSUPPORTED and what admit_body says, 404 SCENE_NOT_FOUND, 409 SCENE_FAILED or
/// SCENE_LOADING (with Retry-After).
std::shared_ptr<const Scene> admit_scene_query(Exchange& exchange, const Service& service);
/// Admits a query whose media type was checked before.
std::shared_ptr<const Scene> admit_query_of_scene(Exchange& exchange, const Service& service);

/// encode_scene, or, where there is no memory for names and warnings, encode_scene_summary: what
/// was done is answered in any case.
std::string text_within(const Exchange& exchange, const StoredScene& scene);
/// Answers so, with the ETag.
void reply_done(Exchange& exchange, int status, const StoredScene& scene);

}  // namespace sightline
