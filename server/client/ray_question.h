#pragma once
/// The common part of the commands cast and query: reads rays, asks, and prints the answers.

#include <cstddef>
#include <functional>
#include <istream>
#include <ostream>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "server/operation/cli.h"

namespace sightline {

/// Answers rays that are lines of JSON (ray_lines.h) below a line of options. Returns the answers as
/// lines of JSON (hit_lines.h).
/// count  number of rays
using AnswerLines = std::function<Result<std::string>(const std::string& lines, std::size_t count)>;

/// "closest", "any", "all" or "count".
std::string_view question_kind(CastMode mode);

/// Prints "sightline: CODE: message" and returns the exit code of an error.
int complain(std::ostream& complaints, const Error& error);

/// Asks all rays of the question and prints a line for each answer, in order. Returns the exit code:
/// 0; 1 if the single ray of the command line misses; 2 for an error.
int ask_rays(const RayQuestion& question, const AnswerLines& answer, std::istream& in,
             std::ostream& out, std::ostream& complaints);

}  // namespace sightline

// Tests: tests/integration/cast_test.py
