#pragma once
/// Admission of queries of a scene, before their bodies are read, and answers to changes of scenes.

#include <memory>
#include <optional>
#include <string>

#include "core/scene/scene.h"
#include "server/http/exchange.h"
#include "server/service/service.h"

namespace sightline {

/// The media types of queries: JSON, also when it comes as a form. A browser sends forms across
/// sites without asking; that can do no harm here, because a query changes nothing and its answer
/// is not shown to the site. Returns false after it has answered.
bool admit_query_type(Exchange& exchange);

/// Admits a body of JSON that changes something or makes the server ask others: other than for a
/// query, no type that a page of another site could send without being allowed to. Returns false
/// after it has answered.
bool admit_json_change(Exchange& exchange, std::uint64_t most_bytes);

/// Reads the body of a query that names no scene. False as read_body.
bool read_query_body(Exchange& exchange, const Service& service, std::string& body);

/// The media type of a query of rays or points: JSON, bytes, or lines where `takes_lines`. Nothing
/// after it has answered.
enum class QueryType { kJson, kBinary, kLines };
std::optional<QueryType> admit_rays_type(Exchange& exchange, bool takes_lines = false);

/// The scene, if it can be asked now. Null after it has answered: 404 SCENE_NOT_FOUND, 409
/// SCENE_FAILED or SCENE_LOADING (with Retry-After).
SceneSnapshot admit_scene(Exchange& exchange, const Service& service);

/// Its scene, and a body that may be read. Null after it has answered:
/// MEDIA_TYPE_UNSUPPORTED and what admit_body says, 404 SCENE_NOT_FOUND, 409 SCENE_FAILED or
/// SCENE_LOADING (with Retry-After).
std::shared_ptr<const Scene> admit_scene_query(Exchange& exchange, const Service& service);
/// Admits a query whose media type was checked before.
std::shared_ptr<const Scene> admit_query_of_scene(Exchange& exchange, const Service& service);

/// Answers with the error of `status`. Returns whether there was none.
bool went_well(Exchange& exchange, const Status& status);

/// When the answer must be there. It passes also when no client waits any more, and soon in the
/// event loop; the request then waits no longer for memory either.
/// timeout_ms  what the client wishes; more than the limit counts as the limit
Deadline deadline_of(const Exchange& exchange, const Service& service,
                     std::optional<std::uint64_t> timeout_ms = {});

/// encode_scene, or, where there is no memory for names and warnings, encode_scene_summary: what
/// was done is answered in any case.
std::string text_within(const Exchange& exchange, const StoredScene& scene);
/// Answers so, with the ETag.
void reply_done(Exchange& exchange, int status, const StoredScene& scene);

}  // namespace sightline
