#include "server/operation/door_flags.h"

#include <algorithm>

#include "server/operation/flag_maker.h"

namespace sightline {

void define_door(CLI::App& app, DoorLimits& limits, DoorSeconds& seconds, DoorBytes& bytes) {
  FlagMaker flags(app);
  app.add_option("--workers", limits.workers, "requests answered at once, and as many heavier ones")
      ->check(CLI::Range(8, 4096))
      ->capture_default_str();
  flags.add_count("--max-queue", limits.queue, "requests that wait for a worker; more are 503");
  flags.add_count("--max-streams", limits.streams,
                  "streams of rays and of events that are open at once; more are 503");
  flags.add_count("--max-connections", limits.connections,
                  "open at once; beyond it those that have been idle the longest are closed");
  flags.add_live("--max-header-bytes", limits.head.bytes, "of one request")
      ->check(CLI::Range(256, 1 << 20));
  flags.add_count("--max-header-fields", limits.head.fields, "of one request");
  app.add_option(
         "--spool-dir", limits.spool_folder,
         "folder for temporary files: what is beyond 64 KiB of a body that comes, and of an "
         "answer that its client has not taken")
      ->capture_default_str();
  flags.add_count("--spool-bytes", limits.spool_bytes, "of these files together; more are 503");
  const auto add_part = [&](const char* name, std::uint64_t& value, const char* help) {
    flags.add_count(name, value, help)->default_str("");
  };
  add_part(
      "--memory", bytes.memory,
      "bytes of memory that connections and requests hold together; one request may take more "
      "while the others hold at most half of it (default: an eighth of the machine's, at least "
      "256 MiB)");
  add_part("--max-buffer-bytes", bytes.buffers,
           "of that, for gathered bodies, long headers and answers that clients have not read "
           "(default: four sevenths)");
  add_part(
      "--max-body-memory", bytes.bodies,
      "of that, for bodies of queries that are being read; one alone may be larger; an eighth is "
      "kept for "
      "small requests, here and in --memory and --max-work-memory (default: nine fourteenths)");
  add_part("--max-work-memory", bytes.work,
           "of that, for answering; one request at a time may take more (default: half)");
  flags.add_count(
      "--max-request-memory", limits.request,
      "bytes that answering one request may take; never more than half of the machine's memory");
  flags.add_live_seconds("--header-seconds", seconds.head, kLeastSeconds,
                         "how long a request's header may take");
  flags.add_live_seconds("--idle-seconds", seconds.idle, kLeastSeconds,
                         "how long a connection may be silent");
  flags.add_count("--min-rate", limits.pace.bytes_per_second,
                  "bytes per second that a client has to send of a body, or take of an answer");
  flags.add_count(
      "--busy-rate", limits.busy_rate,
      "the same of a large answer or body while others wait for the memory that it holds");
  flags.add_live_seconds("--rate-seconds", seconds.window, kLeastSeconds,
                         "over which both are averages");
  flags.add_live_seconds(
      "--body-seconds", seconds.longest, kLeastSeconds,
      "how long one body may take to come, or one answer to be taken, at any rate");
}

void finish_door(DoorLimits& limits, const DoorSeconds& seconds, const DoorBytes& bytes,
                 std::uint64_t machine) {
  constexpr std::uint64_t kLeast = std::uint64_t{256} << 20, kPart = 8;
  limits.traffic = bytes.memory > 0 ? bytes.memory : std::max(kLeast, machine / kPart);
  // The sum bounds all of them: of a small one each kind may use the most.
  const auto part = [&](std::uint64_t given, std::uint64_t least, std::uint64_t fourteenths) {
    return given > 0 ? given : std::max(least, limits.traffic / 14 * fourteenths);
  };
  limits.buffers = part(bytes.buffers, limits.buffers, 8);
  limits.bodies = part(bytes.bodies, limits.bodies, 9);
  limits.work = part(bytes.work, limits.work, 7);
  limits.head_time = milliseconds_of(seconds.head);
  limits.idle = milliseconds_of(seconds.idle);
  limits.pace.window = milliseconds_of(seconds.window);
  limits.pace.longest = milliseconds_of(seconds.longest);
}

}  // namespace sightline
