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

/// Answers with the stream, which holds a worker: so there are only so many at once, and more are
/// 503 EVENTS_BUSY. It ends with the last event, with a stop, when the client is gone, and after an
/// hour. 404 SCENE_NOT_FOUND.
void reply_scene_events(Exchange& exchange, Service& service);

}  // namespace sightline
