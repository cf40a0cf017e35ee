#include "server/routes/routes_jobs.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "proto/json/hit_lines.h"
#include "server/access/access.h"
#include "server/http/ascii.h"
#include "server/http/media_type.h"
#include "server/http/request_body.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kJobs = "/v1/jobs/";

void reply_not_found(Exchange& exchange) {
  exchange.reply_problem(404, "JOB_NOT_FOUND",
                         "there is no job of this id: it was deleted, or has ended long ago");
}

void reply_job(Exchange& exchange, int status, const std::string& id, const JobReport& report) {
  using State = JobReport::State;
  const char* const state = report.state == State::kQueued    ? "queued"
                            : report.state == State::kRunning ? "running"
                                                              : "done";
  Json job{{"id", id}, {"state", state}, {"request", report.target}};
  if (report.state == State::kRunning) {
    const Json of = report.pieces > 0 ? Json(report.pieces) : Json();
    job["progress"] = {{"done", report.pieces_done}, {"of", of}};
  }
  if (report.state == State::kDone) {
    job["status"] = report.status;
    job["result"] = std::string(kJobs) + id + "/result";
    job["expires_seconds"] = report.kept.count();
  }
  exchange.reply_json(status, job.dump() + "\n");
}

void get_job(Exchange& exchange, JobBoard& jobs) {
  const auto report = jobs.find(exchange.job_id, exchange.head.key_name);
  if (!report) return reply_not_found(exchange);
  reply_job(exchange, 200, exchange.job_id, *report);
}

void get_result(Exchange& exchange, JobBoard& jobs) {
  const auto report = jobs.find(exchange.job_id, exchange.head.key_name);
  if (!report) return reply_not_found(exchange);
  if (report->state != JobReport::State::kDone) {
    exchange.reply_problem(409, "JOB_UNFINISHED", "the job has not ended");
    exchange.response.set_header("Retry-After", "1");
    return;
  }
  if (Status status = exchange.reserve(report->bytes); !status)
    return exchange.reply_error(status.error());
  const auto answer = jobs.answer_of(exchange.job_id, exchange.head.key_name);
  if (!answer) return reply_not_found(exchange);
  exchange.response = *answer;
}

void delete_job(Exchange& exchange, JobBoard& jobs) {
  if (!jobs.remove(exchange.job_id, exchange.head.key_name)) return reply_not_found(exchange);
  exchange.reply_empty(204);
}

/// True for a question whose client prefers to fetch the answer later. Streams are answered as they
/// are.
bool is_for_later(const Exchange& exchange) {
  const RequestHead& head = exchange.head;
  return head.prefers_async && head.method == "POST" &&
         needed_access(head.method, head.target) == Access::kRead &&
         !equals_caseless(media_type(exchange), kLinesMediaType);
}

}  // namespace

bool answer_as_job(Exchange& exchange, const Service& service, JobBoard& jobs) {
  if (exchange.whole_body != nullptr || !is_for_later(exchange)) return false;
  exchange.route = "/v1/jobs";
  // A body is copied and a thread is woken: work of a worker.
  if (exchange.on_event_loop) return true;
  const std::uint64_t most = service.limits.query_bytes;
  std::string body;
  if (!admit_body(exchange, most) || !read_body(exchange, most, 0, body)) return true;
  RequestHead head = exchange.head;
  head.prefers_async = false;
  head.coding = Coding::kIdentity;
  head.length = body.size();
  head.chunked = head.expects_continue = false;
  // The result is compressed for the request that fetches it.
  head.accepts = Coding::kIdentity;
  body.shrink_to_fit();
  auto id = jobs.add(head, std::move(body), exchange.request_id);
  if (!id) {
    exchange.reply_error(id.error());
    return true;
  }
  reply_job(exchange, 202, *id, {JobReport::State::kQueued, head.target});
  exchange.response.set_header("Location", std::string(kJobs) + *id);
  exchange.response.set_header("Preference-Applied", "respond-async");
  exchange.response.set_header("Retry-After", "1");
  return true;
}

void add_job_routes(Router& router, JobBoard& jobs) {
  router.add("GET", "/v1/jobs/{job}", with(jobs, get_job));
  router.add("DELETE", "/v1/jobs/{job}", with(jobs, delete_job));
  router.add("GET", "/v1/jobs/{job}/result", with(jobs, get_result));
}

}  // namespace sightline
