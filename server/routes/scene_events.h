#pragma once
/// The states of a scene as server-sent events, until nothing is on its way to it any more.
///
/// - progress: while it is loading, whenever something changed, at most four times a second.
/// - ready, failed or removed: the last one.
///
/// The data of each is one line: what GET /v1/scenes says of the scene.

#include "server/http/exchange.h"
#include "server/service/service.h"

namespace sightline {

/// Answers with a stream of events, on a thread for streams. The stream ends with the last event, on
/// shutdown, when the client has disconnected, and after an hour. 404 SCENE_NOT_FOUND.
void reply_scene_events(Exchange& exchange, Service& service);

}  // namespace sightline
