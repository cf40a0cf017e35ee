#pragma once
/// Estimates the cost of a request before it is answered.

#include <string_view>

#include "server/http/event_loop.h"

namespace sightline {

/// Returns the weight of a request; used as EventLoopCallbacks::weigh.
Weight weigh_request(const RequestHead& head, std::string_view body);

}  // namespace sightline
