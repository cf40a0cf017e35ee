#pragma once
/// The HTTP status of an error, and its name.

#include <string_view>

#include "core/base/result.h"

namespace sightline {

int http_status(ErrorKind kind);
/// The reason phrase of a status and the title of its problems, such as "Unprocessable Entity".
std::string_view status_title(int status);

}  // namespace sightline
