#include "server/operation/http_flags.h"

#include <algorithm>

#include "server/operation/flag_maker.h"

namespace sightline {

void define_http_flags(CLI::App& app, HttpLimits& limits, HttpSeconds& seconds) {
  FlagMaker flags(app);
  app.add_option("--workers", limits.workers,
                 "threads that answer short requests; there are as many for bulk requests")
      ->check(CLI::Range(8, 4096))
      ->capture_default_str();
  flags.add_count("--max-queue", limits.queue,
                  "requests that wait for a worker; further ones are answered with 503");
  flags.add_count("--max-streams", limits.streams,
                  "open streams of rays and events; further ones are answered with 503");
  flags.add_count(
      "--max-connections", limits.connections,
      "open connections; beyond this number, those that have been idle longest are closed");
  flags.add_live("--max-header-bytes", limits.head.bytes, "size of the header of a request")
      ->check(CLI::Range(256, 1 << 20));
  flags.add_count("--max-header-fields", limits.head.fields, "header fields of a request");
  app.add_option(
         "--spool-dir", limits.spool_folder,
         "folder for temporary files: the part beyond 1 MiB of a body that arrives, and beyond "
         "64 KiB of an answer that its client has not received")
      ->capture_default_str()
      ->type_name("FOLDER");
  flags.add_count("--spool-bytes", limits.spool_bytes,
                  "bytes of these files in total; beyond them requests are answered with 503");
  flags
      .add_count(
          "--memory", limits.memory,
          "bytes of memory of connections and requests in total; one request may exceed it while "
          "all others hold at most half of it (default: an eighth of the machine's memory, at "
          "least 256 MiB)")
      ->default_str("");
  flags.add_count("--max-request-memory", limits.request,
                  "bytes of memory of one request; at most half of the machine's memory");
  flags.add_live_seconds("--header-seconds", seconds.head, kLeastSeconds,
                         "longest time to receive the header of a request");
  flags.add_live_seconds("--idle-seconds", seconds.idle, kLeastSeconds,
                         "longest time that a connection may be idle");
  flags.add_count(
      "--min-rate", limits.pace.bytes_per_second,
      "least bytes per second that a client must send of a body or receive of an answer");
  flags.add_count(
      "--busy-rate", limits.busy_rate,
      "least bytes per second of a large body or answer while others need its room in the spool, "
      "and of a stream while others need its memory");
  flags.add_live_seconds("--rate-seconds", seconds.window, kLeastSeconds,
                         "time over which --min-rate and --busy-rate are averaged");
  flags.add_live_seconds("--body-seconds", seconds.longest, kLeastSeconds,
                         "longest time to receive a body or to send an answer, at any rate");
}

void finish_http_flags(HttpLimits& limits, const HttpSeconds& seconds) {
  limits.head_time = milliseconds_of(seconds.head);
  limits.idle = milliseconds_of(seconds.idle);
  limits.pace.window = milliseconds_of(seconds.window);
  limits.pace.longest = milliseconds_of(seconds.longest);
}

}  // namespace sightline
