#pragma once
/// How much a request asks for, as far as that can be seen before it is answered.

#include <string_view>

#include "server/http/request_head.h"

namespace sightline {

/// Whether it goes before those that ask for more. A guess: it decides who answers, not what.
/// `body`: all of it, if the door has it; a longer one is never little.
bool asks_for_little(const RequestHead& head, std::string_view body);

/// Whether to try it on the thread of the door: what takes no longer than to hand it over. The same
/// kind of guess; of what asks for little.
bool fits_the_door(const RequestHead& head, std::string_view body);

}  // namespace sightline
