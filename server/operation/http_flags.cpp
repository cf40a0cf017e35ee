#include "server/operation/http_flags.h"

#include <algorithm>

#include "server/operation/flag_maker.h"

namespace sightline {

void define_http_flags(CLI::App& app, HttpLimits& limits, HttpSeconds& seconds) {
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
  flags
      .add_count(
          "--memory", limits.memory,
          "bytes of memory that connections and requests hold together; one request may take "
          "more while the others hold at most half of it (default: an eighth of the "
          "machine's, at least 256 MiB)")
      ->default_str("");
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
      "least bytes per second of a large body or answer while others need its room in the spool, "
      "and of a stream while others need its memory");
  flags.add_live_seconds("--rate-seconds", seconds.window, kLeastSeconds,
                         "over which both are averages");
  flags.add_live_seconds(
      "--body-seconds", seconds.longest, kLeastSeconds,
      "how long one body may take to come, or one answer to be taken, at any rate");
}

void finish_http_flags(HttpLimits& limits, const HttpSeconds& seconds) {
  limits.head_time = milliseconds_of(seconds.head);
  limits.idle = milliseconds_of(seconds.idle);
  limits.pace.window = milliseconds_of(seconds.window);
  limits.pace.longest = milliseconds_of(seconds.longest);
}

}  // namespace sightline
