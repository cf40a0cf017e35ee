#pragma once
/// Records requests: their counts in the metrics, and a line in the log.

#include <chrono>

#include "server/http/exchange.h"
#include "server/http/request_head.h"
#include "server/operation/log.h"
#include "server/operation/metrics.h"

namespace sightline {

/// Where requests are recorded; both must outlive every copy.
struct Journal {
  Log& log;
  Metrics& metrics;
};

/// Counts and logs a request whose handler has ended. `status` is that of the answer. The line is
/// logged at debug; at warn for a status from 500 on, except 503. `time` is the time since the
/// request was received with its body, or of its head if the body is read in parts.
void note_request(const Journal& journal, const Exchange& exchange, int status,
                  std::chrono::duration<double> time);
/// The record of a stream of rays. Its request is recorded when the stream begins.
struct StreamNote {
  /// Begins the record of the stream that answers `exchange`.
  explicit StreamNote(const Exchange& exchange);

  const std::string path, request_id, key_name;
  const std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
  std::uint64_t rays = 0;
  std::uint64_t bytes = 0;  ///< of the answer, before compression
  std::string code = {};    ///< code of the error that ended the stream; empty: none
};
/// Logs the end of a stream, at debug, or at info if an error ended it.
void note_stream_end(const Journal& journal, const StreamNote& stream);
/// Records a request that the event loop refused. It is counted, and logged at debug; at info for
/// 401 and 403.
void note_refusal(const Journal& journal, const RequestHead& head, const RequestFault& fault,
                  const std::string& request_id);

}  // namespace sightline

// Tests: tests/integration/operator_test.py
