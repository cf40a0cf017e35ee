#pragma once
/// The HTTP status of an error, and its name.

#include <string_view>

#include "core/base/result.h"

namespace sightline {

/// The status in which an error of this kind is answered; 503 for kCancelled, others as in
/// ErrorKind.
int http_status(ErrorKind kind);
/// The reason phrase of a status and the title of its problems, such as "Unprocessable Entity". For
/// an unknown status "Internal Server Error" from 500 on, else "Error".
std::string_view status_title(int status);

}  // namespace sightline

// Tests: tests/integration/errors_test.py
