#pragma once
/// RayRequest: the common part of the routes of rays: reads, describes and answers a request.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/run/engine.h"
#include "core/run/grouped_rays.h"
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

/// One request, for one call of its handler: streamed() if the route has streams, then one of the
/// read functions, the engine, describe(), and reply() or reply_hits(). Functions that return false
/// have answered an error, or put the request off; the handler then returns. Not thread-safe.
class RayRequest {
 public:
  /// Both must outlive the object.
  RayRequest(Exchange& exchange, const Service& service) : exchange_(exchange), service_(service) {}
  /// Records the work of the request, also if it failed.
  ~RayRequest() { exchange_.work = timer_.report.work; }
  RayRequest(const RayRequest&) = delete;
  RayRequest& operator=(const RayRequest&) = delete;

  /// The tables of a question. kJson: none. kColumns: the columns of its binary answer as CSV, NPY or
  /// NPZ (column_table.h). kHits: a row for each slot (hit_table.h), and point clouds.
  enum class Tables { kJson, kColumns, kHits };
  /// Checks the request, finds the scene, reads the body (JSON or binary), and resolves its filter.
  /// `rules` has the keys that the body may have; their limits are set by the service.
  /// `tables`: what the answer may be besides JSON and bytes (table_format.h).
  bool read(RayJsonRules rules, Tables tables);
  /// If the body is a stream (lines, or bytes that begin as one), answers with a stream. Returns
  /// true if the handler must return: after a stream, an error, or if the request was put off. If
  /// false, read() follows.
  bool streamed(RayQuestionKind kind, const Journal& journal);
  /// Reads a body of points (JSON or binary) with its options.
  bool read_points(PointJsonRules rules, PointQuery& points);
  /// Reads a body of sweeps (JSON or binary) with its options.
  bool read_sweeps(SweepJsonRules rules, SweepQuery& sweeps);
  /// Decodes a body; sets the options that are common to all questions.
  using Decode = std::function<Status(std::string& body, QueryOptions& options)>;
  /// Reads a JSON body by `decode`. With Tables::kColumns the answer may be bytes or a table.
  bool read_json(const Decode& decode, Tables tables = Tables::kJson);

  /// The scene of the path. Precondition: a read function returned true.
  const Scene& scene() const { return *scene_; }
  const RayQuery& query() const { return query_; }
  const Deadline& deadline() const { return deadline_; }
  /// Options for the engine, valid while this object lives.
  RayOptions options() {
    return {resolved_ ? &*resolved_ : nullptr, &timer_.report.work, !exchange_.on_event_loop,
            reserve_from(exchange_.memory),    query_.alpha_cutoff, groups_};
  }
  WorkTimer& timer() { return timer_; }
  /// Where to collect warnings about selections; null for a strict request, where they are errors.
  SelectionWarnings* warnings() { return query_.strict ? nullptr : &warnings_; }
  bool is_binary() const { return query_.layout == AnswerLayout::kBinary; }
  /// The invalid rays if they are to be marked, else null.
  const InvalidRays* invalid() const { return query_.marks_invalid ? &query_.invalid : nullptr; }

  /// Adds the time since the last call to a member of the report.
  void add_time(std::uint64_t WorkReport::*step) { timer_.add(step); }

  /// Answers with the error of `status`, if it has one. Returns true if it has none.
  bool went_well(const Status& status) { return sightline::went_well(exchange_, status); }
  /// Reserves memory for the next step.
  bool reserve(std::uint64_t bytes) { return went_well(exchange_.reserve(bytes)); }
  /// Describes hits by the requested fields (describe_within).
  bool describe(const RayBatch& rays, const HitBatch& hits, HitDescription& about);
  /// Sends an encoded answer in the format of the request, with the requested members beside the
  /// hits. Answers with 504 DEADLINE instead if the client's own time limit has passed.
  void reply(std::string encoded) { reply(std::move(encoded), {}); }
  /// Sends an encoded answer with a media type of its own; empty: that of the request.
  void reply(std::string encoded, std::string_view media_type);
  /// Answers with a hit or a miss for each item of the query.
  void reply_hits(const HitBatch& hits, const HitDescription& about);

 private:
  /// Decodes a body of columns, binary or JSON, into query_ or its options, and returns the number of
  /// its items.
  using DecodeColumns = std::function<Result<std::size_t>(std::string& body, bool is_binary)>;
  bool read_columns(FieldSet binary_fields, const DecodeColumns& decode);
  bool read_query(const Decode& decode);
  /// True if a worker must answer. The event loop answers only queries that need neither a
  /// traversal of the whole scene nor a file. Precondition: the query is decoded.
  bool is_for_worker() const;
  /// Groups the rays that have filters of their own.
  bool group();
  /// The cost of the query for BodyReader::may_cost. body_bytes: size of its text.
  std::uint64_t cost(std::size_t body_bytes) const;
  /// Chooses layout and fields of an answer that may be bytes, a picture or a table.
  Status choose_bytes(FieldSet default_fields);
  /// Sets query_.table if the client accepts one of these formats alone.
  void choose_table();

  Exchange& exchange_;
  const Service& service_;
  std::shared_ptr<const Scene> scene_;
  RayQuery query_;
  std::optional<ResolvedFilter> resolved_;
  std::vector<FilteredRays> groups_;  ///< not empty if each ray has a filter
  SelectionWarnings warnings_;
  Deadline deadline_ = Deadline::never();
  WorkTimer timer_;
  Tables tables_ = Tables::kColumns;
  std::string begin_;  ///< the part of the body that was read already
};

}  // namespace sightline

// Tests: tests/integration/rays_test.py
