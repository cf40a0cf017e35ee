#pragma once
/// Estimates how much a request asks for before it is answered.

#include <string_view>

#include "server/http/event_loop.h"

namespace sightline {

/// EventLoopCallbacks::weigh for the routes of scenes.
Weight weigh_request(const RequestHead& head, std::string_view body);

}  // namespace sightline
