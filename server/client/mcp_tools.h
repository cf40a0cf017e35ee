#pragma once
/// The tools that an agent can call, generated from the OpenAPI document.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/client/api_client.h"
#include "server/sources/scene_root.h"

namespace sightline {

/// One operation of the document whose answer is JSON.
struct McpTool {
  std::string name;          ///< its operationId
  std::string method, path;  ///< "POST", "/v1/scenes/{id}/rays:closest"
  std::vector<std::string> path_parameters, query_parameters, header_parameters;
  bool has_body = false;               ///< JSON, the argument "body"
  bool has_file = false;               ///< a file, the argument "file" or its text, "text"
  nlohmann::ordered_json description;  ///< as tools/list tells it
};

/// with_files  whether files of this machine may be uploaded
std::vector<McpTool> mcp_tools(const nlohmann::ordered_json& document, bool with_files);

/// Asks the server. `files` may be null. Errors: ARGUMENTS_INVALID, those of ApiClient and of
/// SceneRoot; what the server refuses is an answer.
Result<ApiAnswer> call_mcp_tool(const McpTool& tool, const nlohmann::json& arguments,
                                ApiClient& client, const SceneRoot* files);

}  // namespace sightline
