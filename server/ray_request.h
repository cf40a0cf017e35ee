#pragma once
/// What the routes of rays share: a request on its way to an answer.

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/run/engine.h"
#include "proto/answer_members.h"
#include "proto/point_json.h"
#include "proto/ray_json.h"
#include "server/exchange.h"
#include "server/service.h"

namespace sightline {

class RayRequest {
 public:
  RayRequest(Exchange& exchange, const Service& service) : exchange_(exchange), service_(service) {}
  /// What it has cost is counted, also where it failed.
  ~RayRequest() { exchange_.work = report_.work; }
  RayRequest(const RayRequest&) = delete;
  RayRequest& operator=(const RayRequest&) = delete;

  /// Admits the request, finds the scene, reads the body, JSON or binary, and works its filter out.
  /// The limits are the service's, the keys are the caller's. Returns false after it has answered.
  bool read(RayJsonRules rules);
  /// The same for a query that comes as JSON and is more than rays: decode(body, options) fills the
  /// options and returns a Status.
  /// The same for points, JSON or binary.
  bool read_points(PointJsonRules rules, PointQuery& points);
  using Decode = std::function<Status(std::string& body, RayQuery& options)>;
  bool read_json(const Decode& decode);

  const Scene& scene() const { return *scene_; }
  const RayQuery& query() const { return query_; }
  const Deadline& deadline() const { return deadline_; }
  RayOptions options() { return {kept_ ? &*kept_ : nullptr, &report_.work}; }
  bool is_binary() const { return query_.layout == AnswerLayout::kBinary; }
  /// The bad rays, where they are to be marked; else null.
  const InvalidRays* invalid() const { return query_.marks_invalid ? &query_.invalid : nullptr; }

  /// Adds the time since the last call to one of WorkReport's.
  void add_time(std::uint64_t WorkReport::*step);

  /// Answers with `status`'s error. Returns whether there was none.
  bool went_well(const Status& status);
  /// Sends what was encoded, JSON or binary as the query came, with what was asked for beside it.
  void reply(std::string encoded);

 private:
  using Clock = std::chrono::steady_clock;
  bool read_query(const Decode& decode);
  Status choose_bytes(RayQuery& query, FieldSet default_fields) const;

  Exchange& exchange_;
  const Service& service_;
  std::shared_ptr<const Scene> scene_;
  RayQuery query_;
  std::optional<KeptSides> kept_;
  Deadline deadline_ = Deadline::never();
  WorkReport report_;
  Clock::time_point last_ = Clock::now();
};

}  // namespace sightline
