#include "server/door_flags.h"

#include <CLI/CLI.hpp>

#include "server/flag_checks.h"

namespace sightline {

void define_door(CLI::App& app, DoorLimits& limits, DoorSeconds& seconds) {
  const CLI::Validator count([](std::string& text) { return check_positive_count(text); },
                             "POSITIVE");
  // Below a millisecond a connection would have no time at all.
  const CLI::Validator span([](std::string& text) { return check_seconds(text, 0.001); },
                            "SECONDS");
  const auto add_count = [&](const char* flag, auto& value, const char* help) {
    app.add_option(flag, value, help)->check(count)->capture_default_str();
  };
  const auto add_span = [&](const char* flag, double& value, const char* help) {
    app.add_option(flag, value, help)->check(span)->capture_default_str();
  };
  app.add_option("--workers", limits.workers,
                 "requests answered at once, and again as many with long or chunked bodies")
      ->check(CLI::Range(8, 4096))
      ->capture_default_str();
  add_count("--max-queue", limits.queue, "requests that wait for a worker; more are 503");
  add_count("--max-connections", limits.connections,
            "open at once; beyond it those that have been idle the longest are closed");
  app.add_option("--max-header-bytes", limits.head.bytes, "of one request")
      ->check(CLI::Range(256, 1 << 20))
      ->capture_default_str();
  add_count("--max-header-fields", limits.head.fields, "of one request");
  add_count("--max-gathered-bytes", limits.gathered,
            "of a body that is received before a worker is taken for it");
  add_count("--max-buffer-bytes", limits.buffers,
            "of such bodies and of answers that clients have not taken yet, together");
  add_count("--max-body-memory", limits.bodies,
            "bytes of longer bodies of queries, together; one alone may be larger");
  add_count("--max-work-memory", limits.work,
            "bytes that answering those may take, together; one alone may take more");
  add_span("--header-seconds", seconds.head, "how long a request's header may take");
  add_span("--idle-seconds", seconds.idle, "how long a connection may be silent");
  add_count("--min-rate", limits.pace.bytes_per_second,
            "bytes per second that a client has to send of a body, or take of an answer");
  add_span("--rate-seconds", seconds.window, "over which that is an average");
  add_span("--body-seconds", seconds.longest,
           "how long one body may take to come, or one answer to be taken, at any rate");
}

void finish_door(DoorLimits& limits, const DoorSeconds& seconds) {
  limits.head_time = milliseconds_of(seconds.head);
  limits.idle = milliseconds_of(seconds.idle);
  limits.pace.window = milliseconds_of(seconds.window);
  limits.pace.longest = milliseconds_of(seconds.longest);
}

}  // namespace sightline
