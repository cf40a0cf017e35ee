#pragma once
/// Sends the states of a scene as server-sent events, until no load of it is queued or running.
///
/// - progress: while the scene is loading, after each change, at most four times a second.
/// - ready, failed or removed: the last event.
///
/// The data of an event is one line: the description of the scene in GET /v1/scenes.

#include "server/http/exchange.h"
#include "server/service/service.h"

namespace sightline {

/// Answers with a stream of events, on a thread for streams. The stream ends with the last event,
/// on shutdown, when the client has disconnected, and after an hour. Errors: 404 SCENE_NOT_FOUND.
void reply_scene_events(Exchange& exchange, Service& service);

}  // namespace sightline
