#pragma once
/// Threads that run for a moment at a time, beside others that run for long.

namespace sightline {

/// The calling thread wants the processor soon and not for long: it may break into the turn of
/// another one. A wish, heard by Linux from 6.12 on; what came before did so by itself.
void ask_for_short_turns();

}  // namespace sightline
