#pragma once
/// Errors as application/problem+json [RFC9457].

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace sightline {

/// One place in the client's body.
struct ProblemPlace {
  std::string pointer;  ///< a JSON pointer; "" is the whole body
  std::string detail;
};

/// {"type":"urn:sightline:problem:RAY_DIRECTION_ZERO","title","status","detail","code","errors",
///  "request_id"}; empty members are left out.
struct Problem {
  int status = 500;
  std::string title;   ///< the same for every problem with this status
  std::string detail;  ///< one sentence about this occurrence
  std::string code;    ///< stable, upper case
  std::vector<ProblemPlace> errors;
  std::string request_id;
};

inline constexpr std::string_view kProblemMediaType = "application/problem+json";

/// Text that is not UTF-8 is repaired, so that an error about bad text is itself good text.
std::string encode_problem(const Problem& problem);

/// `status` and `title` are the caller's: this room knows no HTTP.
Problem make_problem(const Error& error, int status, std::string title);

}  // namespace sightline
