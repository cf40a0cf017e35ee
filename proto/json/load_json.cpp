#include "proto/json/load_json.h"

#include <algorithm>

#include "proto/json/strict_json.h"

namespace sightline {
namespace {

using Json = nlohmann::json;

/// Leaves `out` empty where the key is missing.
Status read_text(const Json& object, const std::string& place, const char* key, std::string& out) {
  const auto found = object.find(key);
  if (found == object.end()) return success();
  if (!found->is_string()) return fault("TYPE_WRONG", "this must be a string", below(place, key));
  out = found->get<std::string>();
  if (out.empty()) return fault("VALUE_UNKNOWN", "this must not be empty", below(place, key));
  return success();
}

Status read_source(const Json& source, LoadRequest& request) {
  const std::string place = "/source";
  if (Status status = check_object(source, place, {"path", "url", "sha256"}); !status)
    return status;
  for (const auto& [key, text] : {std::pair{"path", &request.path}, std::pair{"url", &request.url},
                                  std::pair{"sha256", &request.sha256}}) {
    if (Status status = read_text(source, place, key, *text); !status) return status;
  }
  if (request.path.empty() && request.url.empty()) {
    return fault("KEY_MISSING", "a source has a path or a url", place);
  }
  if (!request.path.empty() && !request.url.empty()) {
    return fault("KEYS_MIXED", "a source has a path or a url, not both", below(place, "url"));
  }
  const bool is_hash = std::all_of(request.sha256.begin(), request.sha256.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
  });
  if (!request.sha256.empty() && (!is_hash || request.sha256.size() != 64)) {
    return fault("VALUE_UNKNOWN", "a SHA-256 has 64 lower-case hexadecimal digits",
                 below(place, "sha256"));
  }
  return success();
}

Status read_options(const Json& options, LoadRequest& request) {
  const std::string place = "/options";
  if (Status status = check_object(options, place, {"scene"}); !status) return status;
  const auto scene = options.find("scene");
  if (scene == options.end()) return success();
  if (!scene->is_number()) return fault("TYPE_WRONG", "this must be a number", "/options/scene");
  if (!scene->is_number_unsigned() || scene->get<std::uint64_t>() > 0xffffffffu) {
    return fault("NUMBER_OUT_OF_RANGE", "the number of a scene is 0, 1, 2, ...", "/options/scene");
  }
  request.scene = static_cast<std::uint32_t>(scene->get<std::uint64_t>());
  return success();
}

}  // namespace

Result<LoadRequest> decode_load_request(std::string_view body) {
  auto parsed = parse_strictly(body);
  if (!parsed) return std::move(parsed).error();
  const Json& document = *parsed;
  LoadRequest request;
  if (Status status = check_object(document, "", {"id", "source", "options"}); !status) {
    return std::move(status).error();
  }
  for (const char* key : {"id", "source"}) {
    if (!document.contains(key)) {
      return fault("KEY_MISSING", std::string("there is no \"") + key + "\"", "");
    }
  }
  if (!document["id"].is_string()) return fault("TYPE_WRONG", "this must be a string", "/id");
  request.id = document["id"].get<std::string>();
  if (Status status = read_source(document["source"], request); !status) {
    return std::move(status).error();
  }
  if (document.contains("options")) {
    if (Status status = read_options(document["options"], request); !status) {
      return std::move(status).error();
    }
  }
  return request;
}

}  // namespace sightline
