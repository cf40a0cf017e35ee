#pragma once
/// The tools that an agent can call, made from the OpenAPI document.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/client/api_client.h"
#include "server/sources/scene_root.h"

namespace sightline {

/// A tool: an operation of the document whose answer is JSON.
struct McpTool {
  std::string name;          ///< the operationId
  std::string method, path;  ///< "POST", "/v1/scenes/{id}/rays:closest"
  std::vector<std::string> path_parameters, query_parameters, header_parameters;
  bool has_body = false;  ///< the body is JSON: the argument "body"
  /// the body is a file: the argument "file" has its path, or "text" its text
  bool has_file = false;
  nlohmann::ordered_json description;  ///< the description in tools/list
};

/// Returns the tools of a document: an OpenAPI document of this program. with_files: files of this
/// machine may be uploaded.
std::vector<McpTool> mcp_tools(const nlohmann::ordered_json& document, bool with_files);

/// Calls a tool: sends its request to the server. Errors: ARGUMENTS_INVALID, those of ApiClient and
/// of SceneRoot. A refusal of the server is an answer, not an error.
/// files  folder of the argument "file", of at most 1 GiB each; null: there is no such argument
Result<ApiAnswer> call_mcp_tool(const McpTool& tool, const nlohmann::json& arguments,
                                ApiClient& client, const SceneRoot* files);

}  // namespace sightline
