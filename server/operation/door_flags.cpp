#include "server/operation/door_flags.h"

#include "server/operation/flag_maker.h"

namespace sightline {

void define_door(CLI::App& app, DoorLimits& limits, DoorSeconds& seconds) {
  FlagMaker flags(app);
  app.add_option("--workers", limits.workers,
                 "requests answered at once; as many more each for heavier ones and for long or "
                 "chunked bodies")
      ->check(CLI::Range(8, 4096))
      ->capture_default_str();
  flags.add_count("--max-queue", limits.queue, "requests that wait for a worker; more are 503");
  flags.add_live_seconds("--queue-seconds", seconds.queue, kLeastSeconds,
                         "how long one whose body is long or chunked may wait for a worker");
  flags.add_count("--max-connections", limits.connections,
                  "open at once; beyond it those that have been idle the longest are closed");
  flags.add_live("--max-header-bytes", limits.head.bytes, "of one request")
      ->check(CLI::Range(256, 1 << 20));
  flags.add_count("--max-header-fields", limits.head.fields, "of one request");
  flags.add_count("--max-gathered-bytes", limits.gathered,
                  "of a body that is received before a worker is taken for it");
  flags.add_count(
      "--max-buffer-bytes", limits.buffers,
      "of such bodies, of long headers on their way and of answers not taken yet, together");
  flags.add_count(
      "--max-body-memory", limits.bodies,
      "bytes of longer bodies of queries, together; one alone may be larger; of this and "
      "the next two an eighth is kept for who asks for little");
  flags.add_count("--max-work-memory", limits.work,
                  "bytes that answering requests may take, together; one at a time may take more");
  flags.add_count("--max-traffic-memory", limits.traffic,
                  "bytes of these three together; one request may take more while the others have "
                  "no more than half of it");
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

void finish_door(DoorLimits& limits, const DoorSeconds& seconds) {
  limits.queue_time = milliseconds_of(seconds.queue);
  limits.head_time = milliseconds_of(seconds.head);
  limits.idle = milliseconds_of(seconds.idle);
  limits.pace.window = milliseconds_of(seconds.window);
  limits.pace.longest = milliseconds_of(seconds.longest);
}

}  // namespace sightline
