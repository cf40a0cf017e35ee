#include "server/client/mcp_tools.h"

#include <algorithm>
#include <set>
#include <span>

namespace sightline {
namespace {

using Ordered = nlohmann::ordered_json;

constexpr std::string_view kSchemas = "#/components/schemas/", kDefinitions = "#/$defs/";
constexpr std::string_view kJsonType = "application/json";
/// This process holds the whole file in memory: so less than the server takes, which is 4 GiB.
constexpr std::uint64_t kMostFileBytes = std::uint64_t{1} << 30;

/// Turns references into the document into such into "$defs", and says which there are.
void move_references(Ordered& schema, std::set<std::string>& found) {
  if (schema.is_array()) {
    for (Ordered& each : schema) move_references(each, found);
  }
  if (!schema.is_object()) return;
  for (auto& [name, value] : schema.items()) {
    if (name == "$ref" && value.is_string()) {
      const std::string target = value.get<std::string>().substr(kSchemas.size());
      found.insert(target);
      value = std::string(kDefinitions) + target;
    } else {
      move_references(value, found);
    }
  }
}

/// All that `schema` refers to, and what that refers to.
Ordered definitions_of(Ordered& schema, const Ordered& document) {
  Ordered definitions = Ordered::object();
  std::set<std::string> wanted;
  move_references(schema, wanted);
  while (!wanted.empty()) {
    const std::string name = *wanted.begin();
    wanted.erase(wanted.begin());
    if (definitions.contains(name)) continue;
    Ordered definition = document["components"]["schemas"][name];
    move_references(definition, wanted);
    definitions[name] = std::move(definition);
  }
  return definitions;
}

/// Of the first answer that is good.
bool answers_with_json(const Ordered& operation) {
  for (const auto& [status, response] : operation["responses"].items()) {
    if (!status.starts_with('2')) continue;
    return !response.contains("content") || response["content"].contains(kJsonType);
  }
  return false;
}

class ToolMaker {
 public:
  ToolMaker(const Ordered& document, std::string path, std::string method, bool with_files)
      : document_(document), with_files_(with_files) {
    tool_.path = std::move(path);
    tool_.method = std::move(method);
  }

  McpTool make(const Ordered& shared, const Ordered& operation) {
    tool_.name = operation["operationId"];
    for (const Ordered* list : {&shared, &operation}) {
      if (list->contains("parameters")) add_parameters((*list)["parameters"]);
    }
    if (operation.contains("requestBody")) add_body(operation["requestBody"]);
    Ordered schema{{"type", "object"}, {"properties", properties_}, {"required", required_}};
    schema["additionalProperties"] = false;
    Ordered definitions = definitions_of(schema, document_);
    if (!definitions.empty()) schema["$defs"] = std::move(definitions);
    tool_.schema = std::move(schema);
    const bool reads = tool_.method == "GET" || tool_.path.find(':') != std::string::npos ||
                       !operation.contains("security");
    tool_.description = {{"name", tool_.name},
                         {"description", text_of_operation(operation)},
                         {"inputSchema", brief_schema(operation)},
                         {"annotations", {{"readOnlyHint", reads}}}};
    if (!reads) tool_.description["annotations"]["destructiveHint"] = tool_.method != "POST";
    return std::move(tool_);
  }

 private:
  /// The schema in the list of tools: the body is named by its keys and an example.
  [[nodiscard]] Ordered brief_schema(const Ordered& operation) const {
    Ordered brief{{"type", "object"}, {"properties", Ordered::object()}};
    for (const auto& [name, schema] : properties_.items()) {
      Ordered& property = brief["properties"][name];
      if (name == "body") {
        property = brief_body(operation["requestBody"]["content"][kJsonType]);
        continue;
      }
      property["type"] = schema["type"];
      if (name != "id" && schema.contains("description")) {
        property["description"] = schema["description"];
      }
    }
    if (!required_.empty()) brief["required"] = required_;
    return brief;
  }
  [[nodiscard]] Ordered brief_body(const Ordered& content) const {
    const std::string reference = content["schema"]["$ref"];
    const Ordered& query = document_["components"]["schemas"][reference.substr(kSchemas.size())];
    std::string keys;
    for (const auto& [name, property] : query["properties"].items()) {
      keys.append(keys.empty() ? "keys: " : ", ").append(name);
    }
    Ordered brief{{"type", "object"}, {"description", keys}};
    // Braces alone are a list of one with g++, and its element with clang.
    if (content.contains("example")) brief["examples"] = Ordered::array({content["example"]});
    return brief;
  }
  /// What it answers, and when to use it.
  static std::string text_of_operation(const Ordered& operation) {
    return operation["summary"].get<std::string>() + ". " +
           operation.value("description", std::string());
  }
  void add_parameters(const Ordered& parameters) {
    for (const Ordered& each : parameters) {
      const std::string name = each["name"];
      Ordered schema = each["schema"];
      if (each.contains("description")) schema["description"] = each["description"];
      properties_[name] = std::move(schema);
      (each["in"] == "path"    ? tool_.path_parameters
       : each["in"] == "query" ? tool_.query_parameters
                               : tool_.header_parameters)
          .push_back(name);
      if (each.value("required", false)) required_.push_back(name);
    }
  }
  void add_body(const Ordered& body) {
    const Ordered& content = body["content"];
    if (content.contains(kJsonType)) {
      tool_.has_body = true;
      properties_["body"] = content[kJsonType]["schema"];
      required_.push_back("body");
      return;
    }
    tool_.has_file = true;
    properties_["text"] = {{"type", "string"},
                           {"description", "the file itself, where it is text"}};
    if (with_files_) {
      properties_["file"] = {{"type", "string"},
                             {"description",
                              "instead of the text a file, below the folder that "
                              "this client was given"}};
    } else {
      required_.push_back("text");
    }
  }

  const Ordered& document_;
  const bool with_files_;
  McpTool tool_;
  Ordered properties_ = Ordered::object(), required_ = Ordered::array();
};

Error wrong_argument(const std::string& what) {
  return {ErrorKind::kInvalid, "ARGUMENTS_INVALID", what, ""};
}

/// A parameter as a path or a query has it.
std::optional<std::string> text_of(const nlohmann::json& value) {
  if (value.is_string()) return percent_encoded(value.get<std::string>());
  if (value.is_number() || value.is_boolean()) return percent_encoded(value.dump());
  return std::nullopt;
}

Result<std::string> path_of(const McpTool& tool, const nlohmann::json& arguments) {
  std::string path = tool.path;
  for (const std::string& name : tool.path_parameters) {
    const auto value = arguments.contains(name) ? text_of(arguments[name]) : std::nullopt;
    if (!value || value->empty()) return wrong_argument("\"" + name + "\" has to be a text");
    path.replace(path.find("{" + name + "}"), name.size() + 2, *value);
  }
  char before = '?';
  for (const std::string& name : tool.query_parameters) {
    if (!arguments.contains(name)) continue;
    const auto value = text_of(arguments[name]);
    if (!value) return wrong_argument("\"" + name + "\" has to be a text or a number");
    path.append(1, before).append(name).append("=").append(*value);
    before = '&';
  }
  return path;
}

/// Errors: ARGUMENTS_INVALID, also of what cannot stand in a line of a header.
Result<ApiHeaders> headers_of(const McpTool& tool, const nlohmann::json& arguments) {
  ApiHeaders headers;
  for (const std::string& name : tool.header_parameters) {
    if (!arguments.contains(name)) continue;
    const auto& value = arguments[name];
    const std::string text = value.is_string() ? value.get<std::string>() : "";
    const bool is_line = !text.empty() && std::all_of(text.begin(), text.end(),
                                                      [](char c) { return c >= ' ' && c <= '~'; });
    if (!is_line) return wrong_argument("\"" + name + "\" has to be a line of ASCII");
    headers.emplace_back(name, text);
  }
  return headers;
}

Result<std::string> file_of(const nlohmann::json& arguments, const SceneRoot* files) {
  if (arguments.contains("text") && !arguments.contains("file") && arguments["text"].is_string()) {
    return arguments["text"].get<std::string>();
  }
  if (files == nullptr || arguments.contains("text") || !arguments.contains("file") ||
      !arguments["file"].is_string()) {
    return wrong_argument(files == nullptr ? "\"text\" has to be a text"
                                           : "needs a \"text\" or a \"file\"");
  }
  const auto file = files->open_file(arguments["file"].get<std::string>(), kMostFileBytes);
  if (!file) return file.error();
  std::string bytes;
  const Status read = read_file(*file, kMostFileBytes, [&](std::span<const std::byte> piece) {
    bytes.append(reinterpret_cast<const char*>(piece.data()), piece.size());
    return success();
  });
  if (!read) return read.error();
  return bytes;
}

/// A tool that needs no server.
McpTool local_tool(std::string_view name, std::string_view text, Ordered properties,
                   Ordered required) {
  McpTool tool;
  tool.name = name;
  tool.schema = {{"type", "object"},
                 {"properties", std::move(properties)},
                 {"required", std::move(required)},
                 {"additionalProperties", false}};
  tool.description = {{"name", name},
                      {"description", text},
                      {"inputSchema", tool.schema},
                      {"annotations", {{"readOnlyHint", true}}}};
  return tool;
}

}  // namespace

Status check_mcp_arguments(const McpTool& tool, const nlohmann::json& arguments) {
  if (!arguments.is_object()) return wrong_argument("arguments are an object");
  const auto& known = tool.schema["properties"];
  for (const auto& [name, value] : arguments.items()) {
    if (!known.contains(name)) return wrong_argument("there is no argument \"" + name + "\"");
  }
  return success();
}

std::vector<McpTool> mcp_tools(const Ordered& document, bool with_files) {
  std::vector<McpTool> tools;
  for (const auto& [path, item] : document["paths"].items()) {
    for (const auto& [method, operation] : item.items()) {
      if (method == "parameters" || !answers_with_json(operation)) continue;
      std::string upper = method;
      std::transform(upper.begin(), upper.end(), upper.begin(),
                     [](char c) { return static_cast<char>(c - 'a' + 'A'); });
      tools.push_back(ToolMaker(document, path, upper, with_files).make(item, operation));
    }
  }
  const Ordered count{{"type", "integer"}, {"minimum", 0}}, text{{"type", "string"}};
  tools.push_back(local_tool(kDescribeTool,
                             "The exact schema of a tool's arguments. Use it before a call with "
                             "keys that the example of the tool does not show.",
                             {{"name", text}}, {"name"}));
  tools.push_back(local_tool(
      kReadAnswer,
      "A page of a long answer. Use it after an answer with \"next\" or \"shortened\": \"first\" "
      "is that \"next\", \"pointer\" a JSON pointer such as /hits/7 to a part. A question with "
      "fewer fields, or rays:count and rays:any, often needs no pages.",
      {{"answer", count}, {"pointer", text}, {"first", count}}, Ordered::array()));
  return tools;
}

Result<ApiAnswer> call_mcp_tool(const McpTool& tool, const nlohmann::json& arguments,
                                ApiClient& client, const SceneRoot* files) {
  const auto path = path_of(tool, arguments);
  if (!path) return path.error();
  const auto headers = headers_of(tool, arguments);
  if (!headers) return headers.error();
  if (tool.has_body) {
    if (!arguments.contains("body")) return wrong_argument("\"body\" is missing");
    return client.ask(tool.method, *path, arguments["body"].dump(), std::string(kJsonType),
                      *headers);
  }
  if (!tool.has_file) return client.ask(tool.method, *path, {}, {}, *headers);
  const auto file = file_of(arguments, files);
  if (!file) return file.error();
  return client.ask(tool.method, *path, *file, "application/octet-stream", *headers);
}

}  // namespace sightline
