#include "server/sources/origin_choice.h"

#include <algorithm>
#include <map>
#include <string_view>

#include "core/base/plain_name.h"
#include "core/store/origin_folder.h"
#include "core/store/posix_file.h"
#include "server/sources/s3_origin.h"

namespace sightline {
namespace {

constexpr std::string_view kScheme = "s3://";
constexpr std::size_t kMostFile = 64 << 10;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

Error invalid(std::string message) {
  return {ErrorKind::kInvalid, "ORIGIN_INVALID", std::move(message), ""};
}

Error no_credentials(std::string message) {
  return {ErrorKind::kInvalid, "ORIGIN_CREDENTIALS", std::move(message), ""};
}

/// The names and values of the first section.
Result<std::map<std::string, std::string>> read_values(const std::string& file) {
  std::map<std::string, std::string> values;
  if (file.empty()) return values;
  const auto text = read_small_file(file, kMostFile, "read the credentials of the origin");
  if (!text) return text.error();
  std::string_view rest = *text;
  bool has_section = false;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = trimmed(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.empty() || line.front() == '#' || line.front() == ';') continue;
    if (line.front() == '[') {
      if (has_section || !values.empty()) break;
      has_section = true;
      continue;
    }
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) {
      return no_credentials("a line of the file of credentials is not NAME = VALUE");
    }
    values[std::string(trimmed(line.substr(0, equals)))] = trimmed(line.substr(equals + 1));
  }
  return values;
}

/// A bucket, or a part of a prefix: what needs no encoding in a URL.
bool is_part(std::string_view text) { return is_plain_name(text); }

}  // namespace

Result<std::shared_ptr<Origin>> open_origin(
    const std::string& text, const std::string& credentials,
    const std::function<std::string(const char* name)>& environment) {
  if (!text.starts_with(kScheme)) {
    if (text.find("://") != std::string::npos) {
      return invalid("an origin is a folder or s3://BUCKET[/PREFIX]");
    }
    auto folder = OriginFolder::open(text);
    if (!folder) return std::move(folder).error();
    return std::shared_ptr<Origin>(std::move(*folder));
  }
  S3Bucket bucket;
  std::string_view rest = std::string_view(text).substr(kScheme.size());
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('/'), rest.size());
    const std::string_view part = rest.substr(0, end);
    if (!is_part(part)) {
      return invalid(
          "a bucket and the parts of a prefix have 1 to 128 of the characters A-Z a-z "
          "0-9 . _ - and do not begin with a dot");
    }
    if (bucket.bucket.empty()) {
      bucket.bucket = part;
    } else {
      bucket.prefix.append(part).append("/");
    }
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  if (bucket.bucket.empty()) return invalid("an origin s3://BUCKET needs the name of a bucket");
  auto values = read_values(credentials);
  if (!values) return std::move(values).error();
  const auto value = [&](const char* name, const char* variable) {
    const auto found = values->find(name);
    return found != values->end() ? found->second : environment(variable);
  };
  bucket.key_id = value("aws_access_key_id", "AWS_ACCESS_KEY_ID");
  bucket.secret = value("aws_secret_access_key", "AWS_SECRET_ACCESS_KEY");
  bucket.token = value("aws_session_token", "AWS_SESSION_TOKEN");
  bucket.region = value("region", "AWS_REGION");
  bucket.endpoint = value("endpoint_url", "AWS_ENDPOINT_URL");
  if (bucket.key_id.empty() || bucket.secret.empty()) {
    return no_credentials(
        "an origin in S3 needs --origin-credentials FILE, or AWS_ACCESS_KEY_ID and "
        "AWS_SECRET_ACCESS_KEY in the environment");
  }
  if (bucket.region.empty()) bucket.region = "us-east-1";
  if (bucket.endpoint.empty()) {
    bucket.endpoint = "https://s3." + bucket.region + ".amazonaws.com";
  }
  while (bucket.endpoint.ends_with('/')) bucket.endpoint.pop_back();
  if (!bucket.endpoint.starts_with("http://") && !bucket.endpoint.starts_with("https://")) {
    return invalid("the endpoint of an origin begins with http:// or https://");
  }
  return std::shared_ptr<Origin>(std::make_shared<S3Origin>(std::move(bucket)));
}

}  // namespace sightline
