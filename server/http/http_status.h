#pragma once
/// Which HTTP status an error has, and what it is called.

#include <string_view>

#include "core/base/result.h"

namespace sightline {

int http_status(ErrorKind kind);
/// "Unprocessable Entity": the reason phrase of an answer, and the title of a problem
std::string_view status_title(int status);

}  // namespace sightline
