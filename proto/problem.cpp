#include "proto/problem.h"

#include <nlohmann/json.hpp>

namespace sightline {

std::string encode_problem(const Problem& problem) {
  // Ordered, so that people find the same member in the same place each time.
  nlohmann::ordered_json document;
  document["type"] = "urn:sightline:problem:" + problem.code;
  document["title"] = problem.title;
  document["status"] = problem.status;
  if (!problem.detail.empty()) document["detail"] = problem.detail;
  document["code"] = problem.code;
  if (!problem.errors.empty()) {
    auto& errors = document["errors"] = nlohmann::ordered_json::array();
    for (const ProblemPlace& place : problem.errors) {
      nlohmann::ordered_json entry;
      entry["pointer"] = place.pointer;
      if (!place.detail.empty()) entry["detail"] = place.detail;
      errors.push_back(std::move(entry));
    }
  }
  if (!problem.request_id.empty()) document["request_id"] = problem.request_id;
  return document.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

Problem make_problem(const Error& error, int status, std::string title) {
  Problem problem;
  problem.status = status;
  problem.title = std::move(title);
  problem.detail = error.message;
  problem.code = error.code;
  if (!error.pointer.empty()) problem.errors.push_back({error.pointer, error.message});
  return problem;
}

}  // namespace sightline
