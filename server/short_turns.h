#pragma once
/// Threads that run for a moment at a time, beside others that run for long.

namespace sightline {

/// The calling thread wants the processor soon and not for long: it may break into the turn of
/// another one. A wish, heard by Linux from 6.12 on; what came before did so by itself.
void ask_for_short_turns();

/// The calling thread runs before all that are scheduled as usual, where that is allowed
/// (CAP_SYS_NICE, RLIMIT_RTPRIO) and leaves them a processor. Threads that it makes do not.
/// For one that never computes for long.
void ask_to_go_first();

}  // namespace sightline
