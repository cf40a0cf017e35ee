#pragma once
/// Which HTTP status an error has, and what it is called.

#include <string>

#include "core/base/result.h"

namespace sightline {

int http_status(ErrorKind kind);
/// "Unprocessable Entity"
std::string status_title(int status);

}  // namespace sightline
