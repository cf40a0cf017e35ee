#pragma once
/// Encodes errors as application/problem+json [RFC9457].

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace sightline {

/// A place in the client's body, with its error.
struct ProblemPlace {
  std::string pointer;  ///< a JSON pointer; "" is the whole body
  std::string detail;
};

/// A problem document:
/// {"type":"urn:sightline:problem:RAY_DIRECTION_ZERO","title","status","detail","code","errors",
///  "request_id"}; empty members are left out.
struct Problem {
  int status = 500;
  std::string title;   ///< equal for all problems with this status
  std::string detail;  ///< one sentence about this error
  std::string code;    ///< stable, in upper case
  std::vector<ProblemPlace> errors;
  std::string request_id;
};

/// The media type of a problem document.
inline constexpr std::string_view kProblemMediaType = "application/problem+json";

/// Encodes a problem as one line of JSON. Invalid UTF-8 in texts is replaced, so that the document
/// is valid.
std::string encode_problem(const Problem& problem);

/// Makes a problem of an error; its pointer becomes the only entry of `errors`, if it is not empty.
/// The caller gives `status` and `title`, because this room does not know HTTP.
Problem make_problem(const Error& error, int status, std::string title);

}  // namespace sightline
