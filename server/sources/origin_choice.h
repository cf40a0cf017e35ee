#pragma once
/// Which origin a server uses: what --origin and --origin-credentials say.

#include <functional>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/store/origin.h"

namespace sightline {

/// Opens an origin.
/// text         a folder, or s3://BUCKET[/PREFIX]
/// credentials  a file of lines NAME = VALUE as ~/.aws/credentials has them, or empty. Names:
///              aws_access_key_id, aws_secret_access_key, aws_session_token, region, endpoint_url;
///              of several sections [...] the first is read
/// environment  returns the value of a variable, or empty: AWS_ACCESS_KEY_ID,
///              AWS_SECRET_ACCESS_KEY, AWS_SESSION_TOKEN, AWS_REGION, AWS_ENDPOINT_URL. The file
///              takes precedence. Without a region it is us-east-1, without an endpoint that of
///              Amazon
/// Errors: ORIGIN_INVALID, ORIGIN_CREDENTIALS, those of io_error.
Result<std::shared_ptr<Origin>> open_origin(
    const std::string& text, const std::string& credentials,
    const std::function<std::string(const char* name)>& environment);

}  // namespace sightline

// Tests: tests/unit/server/origin_choice_test.cpp
