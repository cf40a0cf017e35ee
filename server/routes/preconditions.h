#pragma once
/// Reads If-Match and If-None-Match of a request.

#include "core/store/precondition.h"
#include "server/http/exchange.h"

namespace sightline {

/// The precondition of a request by [RFC9110] 13.1. If-Match is compared strongly, so a weak tag
/// matches nothing; If-None-Match is compared weakly.
Precondition precondition_of(const Exchange& exchange);

}  // namespace sightline

// Tests: tests/integration/scenes_test.py
