#pragma once
/// Sends the states of a scene as server-sent events, until no load of it is queued or running.
///
/// - progress: while the scene is loading, after each change, at most four times a second.
/// - ready, failed or removed: the last event.
///
/// The data of an event is one line: the description of the scene in GET /v1/scenes, or {"id":...}
/// for removed. After five seconds without an event, a comment line is sent.

#include "server/http/exchange.h"
#include "server/service/service.h"

namespace sightline {

/// Answers with a stream of events, on a thread for streams. The stream ends with the last event,
/// on shutdown, when the client has disconnected or its key is revoked, and after an hour. Answers
/// 404 SCENE_NOT_FOUND for an unknown scene. `service` must outlive the stream.
void reply_scene_events(Exchange& exchange, Service& service);

}  // namespace sightline

// Tests: tests/integration/loads_test.py
