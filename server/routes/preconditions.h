#pragma once
/// If-Match and If-None-Match of a request.

#include "core/store/precondition.h"
#include "server/http/exchange.h"

namespace sightline {

/// [RFC9110] 13.1: If-Match is compared strongly, so a weak tag is nobody's; If-None-Match weakly.
Precondition precondition_of(const Exchange& exchange);

}  // namespace sightline
