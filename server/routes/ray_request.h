#pragma once
/// The common part of the routes of rays: decoding, tracing and answering a request.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/run/engine.h"
#include "proto/json/answer_members.h"
#include "proto/json/point_json.h"
#include "proto/json/ray_json.h"
#include "proto/json/sweep_json.h"
#include "server/http/exchange.h"
#include "server/http/request_memory.h"
#include "server/operation/request_log.h"
#include "server/routes/scene_admission.h"
#include "server/service/hit_terms.h"
#include "server/service/ray_answer.h"
#include "server/service/service.h"

namespace sightline {

class RayRequest {
 public:
  RayRequest(Exchange& exchange, const Service& service) : exchange_(exchange), service_(service) {}
  /// Counts the work of the request, also if it failed.
  ~RayRequest() { exchange_.work = timer_.report.work; }
  RayRequest(const RayRequest&) = delete;
  RayRequest& operator=(const RayRequest&) = delete;

  /// Admits the request, finds the scene, reads the body, JSON or binary, and works its filter out.
  /// The limits are the service's, the keys are the caller's. Returns false after it has answered.
  bool read(RayJsonRules rules);
  /// Starts a stream, and returns true, if the body is one: lines, or bytes that begin so.
  bool streamed(RayQuestionKind kind, const Journal& journal);
  /// Reads points, JSON or binary, with their options.
  bool read_points(PointJsonRules rules, PointQuery& points);
  /// Reads sweeps, JSON or binary, with their options.
  bool read_sweeps(SweepJsonRules rules, SweepQuery& sweeps);
  using Decode = std::function<Status(std::string& body, RayQuery& options)>;
  bool read_json(const Decode& decode);

  const Scene& scene() const { return *scene_; }
  const RayQuery& query() const { return query_; }
  const Deadline& deadline() const { return deadline_; }
  RayOptions options() {
    return {resolved_ ? &*resolved_ : nullptr, &timer_.report.work, !exchange_.on_event_loop,
            reserve_from(exchange_.memory)};
  }
  WorkTimer& timer() { return timer_; }
  /// The collector of warnings about selections; null for a strict question, which fails instead.
  SelectionWarnings* warnings() { return query_.strict ? nullptr : &warnings_; }
  bool is_binary() const { return query_.layout == AnswerLayout::kBinary; }
  /// The bad rays, where they are to be marked; else null.
  const InvalidRays* invalid() const { return query_.marks_invalid ? &query_.invalid : nullptr; }

  void add_time(std::uint64_t WorkReport::*step) { timer_.add(step); }

  /// Answers with `status`'s error. Returns whether there was none.
  bool went_well(const Status& status) { return sightline::went_well(exchange_, status); }
  /// Takes memory for what comes next. Returns false after it has answered.
  bool reserve(std::uint64_t bytes) { return went_well(exchange_.reserve(bytes)); }
  /// describe_within for the fields asked for. Returns false after it has answered.
  bool describe(const RayBatch& rays, const HitBatch& hits, HitDescription& about);
  /// Sends what was encoded, JSON or binary as the query came, with what was asked for beside it.
  void reply(std::string encoded);
  /// Answers with a hit or none for each item of the query.
  void reply_hits(const HitBatch& hits, const HitDescription& about);

 private:
  /// Decodes a body, binary or JSON, and says how many items it asks about.
  using DecodeColumns =
      std::function<Result<std::size_t>(std::string& body, bool is_binary, RayQuery& options)>;
  bool read_columns(FieldSet binary_fields, const DecodeColumns& decode);
  bool read_query(const Decode& decode);
  /// Whether a worker must answer. The event loop answers only queries that need no traversal of
  /// the whole scene and no file. Precondition: the query is decoded.
  bool is_for_worker() const;
  /// Of the query, see BodyReader::may_cost. body_bytes  of its text
  std::uint64_t cost(std::size_t body_bytes) const;
  Status choose_bytes(RayQuery& query, FieldSet default_fields) const;

  Exchange& exchange_;
  const Service& service_;
  std::shared_ptr<const Scene> scene_;
  RayQuery query_;
  std::optional<ResolvedFilter> resolved_;
  SelectionWarnings warnings_;
  Deadline deadline_ = Deadline::never();
  WorkTimer timer_;
  std::string begin_;  ///< of the body, what was read already
};

}  // namespace sightline
