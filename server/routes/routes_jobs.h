#pragma once
/// Questions that are answered in the background: "Prefer: respond-async" [RFC7240].

#include "server/http/job_board.h"
#include "server/routes/routes.h"

namespace sightline {

/// If the client prefers a question to be answered later, makes a job of it, answers 202 with its
/// Location, or an error, or puts the request off, and returns true. Errors: those of read_body and
/// JobBoard::add.
bool answer_as_job(Exchange& exchange, const Service& service, JobBoard& jobs);

/// State, result and end of jobs. `jobs` must outlive the router's use.
void add_job_routes(Router& router, JobBoard& jobs);

}  // namespace sightline

// Tests: tests/integration/jobs_test.py
