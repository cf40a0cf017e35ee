#pragma once
/// The tools that an agent can call, made from the OpenAPI document.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
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
  nlohmann::ordered_json schema;       ///< JSON schema of the arguments, with all definitions
  nlohmann::ordered_json description;  ///< the description in tools/list, with a brief schema
};

/// Tools that need no server: the schema of a tool, and a page of a long answer (McpPages).
inline constexpr std::string_view kDescribeTool = "describeTool", kReadAnswer = "readAnswer";

/// Returns the tools of a document, an OpenAPI document of this program, and then the tools that
/// need no server. with_files: files of this machine may be uploaded.
std::vector<McpTool> mcp_tools(const nlohmann::ordered_json& document, bool with_files);

/// Checks that the arguments are an object, and that the tool has each of them. Errors:
/// ARGUMENTS_INVALID.
Status check_mcp_arguments(const McpTool& tool, const nlohmann::json& arguments);

/// Calls a tool with arguments that passed check_mcp_arguments(): sends its request to the server.
/// Errors: ARGUMENTS_INVALID, those of ApiClient and of SceneRoot. A refusal of the server is an
/// answer, not an error.
/// files  folder of the argument "file", of at most 1 GiB each; null: there is no such argument
Result<ApiAnswer> call_mcp_tool(const McpTool& tool, const nlohmann::json& arguments,
                                ApiClient& client, const SceneRoot* files);

}  // namespace sightline

// Tests: tests/integration/mcp_test.py
