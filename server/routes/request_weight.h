#pragma once
/// How much a request asks for, as far as that can be seen before it is answered.

#include <string_view>

#include "server/http/request_head.h"

namespace sightline {

/// Whether a request has priority because it needs little. An estimate: it decides which thread
/// answers, not the answer. `body`: all of it, if the event loop has it; a longer body never counts
/// as little.
bool asks_for_little(const RequestHead& head, std::string_view body);

/// Whether the event loop should try the request inline, because it takes no longer than a
/// hand-over to a worker. An estimate too; only for requests that need little.
bool fits_the_door(const RequestHead& head, std::string_view body);

/// Whether it goes over all of a scene, whatever its parameters: a long request.
bool walks_scene(const RequestHead& head);

}  // namespace sightline
