#pragma once
/// Admits requests about scenes: media type, size of the body, scene. read_query_body also reads the
/// body. Answers changes of scenes.

#include <memory>
#include <optional>
#include <string>

#include "core/scene/scene.h"
#include "server/http/exchange.h"
#include "server/service/service.h"

namespace sightline {

/// Checks the media type of a query: JSON, also if it is sent as a form. A browser may send a form
/// to another site without permission; that is harmless here, because a query changes nothing and
/// the page cannot read the answer. Returns false after it has answered.
bool admit_query_type(Exchange& exchange);

/// Admits a JSON body that changes something, or makes the server connect to others. Unlike for a
/// query, media types are refused that a page of another site could send without permission.
/// Returns false after it has answered.
bool admit_json_change(Exchange& exchange, std::uint64_t most_bytes);

/// Checks media type and size of the body of a query that names no scene, and reads it. Returns
/// false after it has answered an error, or if the request was put off.
bool read_query_body(Exchange& exchange, const Service& service, std::string& body);

/// The media type of a query of rays or points.
enum class QueryType { kJson, kBinary, kLines };
/// Checks the media type: JSON, binary, or lines if `takes_lines`. Empty after it has answered.
std::optional<QueryType> admit_rays_type(Exchange& exchange, bool takes_lines = false);

/// The scene that the request names, in any state, of a revision that the request accepts
/// (SceneStore::obtain). Empty if the request is answered, or put off from the event loop. Answers:
/// SCENE_NOT_FOUND, REVISION_INVALID (400), ORIGIN_BUSY (503), those of SceneStore::obtain.
std::optional<SceneSnapshot> obtain_scene(Exchange& exchange, const Service& service,
                                          const Deadline& deadline);

/// Answers 404 SCENE_NOT_FOUND with at most three similar names. Cost: grows with the number of
/// scenes, some nanoseconds for each.
void reply_scene_not_found(Exchange& exchange, const Service& service);
/// Answers an error of a SceneStore; SCENE_NOT_FOUND as above.
void reply_store_error(Exchange& exchange, const Service& service, const Error& error);
/// Returns a scene that can be queried now, and sets the header X-Scene-Revision. Null after it has
/// answered an error (of obtain_scene; 409 SCENE_FAILED; 409 SCENE_LOADING with Retry-After), or if
/// the request was put off from the event loop.
SceneSnapshot admit_scene(Exchange& exchange, const Service& service);

/// Checks media type, body and scene of a query, and returns the scene. Null as for admit_scene, or
/// after it has answered MEDIA_TYPE_UNSUPPORTED or an error of admit_body.
std::shared_ptr<const Scene> admit_scene_query(Exchange& exchange, const Service& service);
/// Checks body and scene of a query whose media type was checked before, and returns the scene. Null
/// as for admit_scene_query.
std::shared_ptr<const Scene> admit_query_of_scene(Exchange& exchange, const Service& service);

/// Answers with the error of `status`, if it has one. Returns true if it has none.
bool went_well(Exchange& exchange, const Status& status);

/// The deadline of an answer. It also passes when the client no longer waits, and on the event loop
/// after 300 microseconds. The request does not wait for memory beyond it.
/// timeout_ms  the client's limit, from the arrival of the request; the server's limit, from now,
///             applies if it ends earlier
/// threads     the client's limit of threads; 0: no limit. Stored in Deadline::threads
Deadline deadline_of(const Exchange& exchange, const Service& service,
                     std::optional<std::uint64_t> timeout_ms = {}, int threads = 0);

/// encode_scene or, if there is no memory for names and warnings, encode_scene_summary, so that a
/// completed change is answered in any case.
std::string text_within(const Exchange& exchange, const StoredScene& scene);
/// Answers with `status`, text_within and the ETag.
void reply_done(Exchange& exchange, int status, const StoredScene& scene);

}  // namespace sightline

// Tests: tests/integration/errors_test.py
