#pragma once
/// What is kept of each request: its counts in the metrics and its line in the log.

#include <chrono>

#include "server/exchange.h"
#include "server/request_head.h"
#include "server/service.h"

namespace sightline {

/// Of a request that was answered, or whose answer failed by an exception and has this status.
void note_request(Service& service, const Exchange& exchange, int status,
                  std::chrono::duration<double> time);
/// Of one that came no further than the door.
void note_refusal(Service& service, const RequestHead& head, const RequestFault& fault,
                  const std::string& request_id);

}  // namespace sightline
