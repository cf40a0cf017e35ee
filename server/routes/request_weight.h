#pragma once
/// Estimates the cost of a request before it is answered.

#include <string_view>

#include "server/http/event_loop.h"

namespace sightline {

/// Returns the weight of a request, by its path and by the size and words of its body; used as
/// EventLoopCallbacks::weigh. Thread-safe.
Weight weigh_request(const RequestHead& head, std::string_view body);

}  // namespace sightline
