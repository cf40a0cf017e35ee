#include "server/client/commands.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "proto/openapi_document.h"
#include "server/client/json_depth.h"
#include "server/client/mcp_pages.h"
#include "server/client/mcp_tools.h"
#include "server/operation/version.h"

namespace sightline {
namespace {

using Json = nlohmann::json;
using Ordered = nlohmann::ordered_json;

constexpr std::array<std::string_view, 3> kMcpRevisions{"2025-06-18", "2025-03-26", "2024-11-05"};
constexpr std::string_view kPictureType = "image/png";
constexpr std::size_t kLongestLine = 256 << 20;
/// A page of a smaller size has no elements, so that it cannot become shorter.
constexpr std::size_t kLeastPage = 512;

// The numbers of JSON-RPC 2.0.
constexpr int kParseError = -32700, kInvalidRequest = -32600, kNoSuchMethod = -32601,
              kInvalidParams = -32602;

Ordered fault(const Json& id, int code, const std::string& message) {
  return {{"jsonrpc", "2.0"}, {"id", id}, {"error", {{"code", code}, {"message", message}}}};
}

Ordered result(const Json& id, Ordered value) {
  return {{"jsonrpc", "2.0"}, {"id", id}, {"result", std::move(value)}};
}

/// As a line. Texts may hold bytes that are no UTF-8: they come from requests and answers.
std::string printed(const Ordered& value) {
  return value.dump(-1, ' ', false, Ordered::error_handler_t::replace);
}

std::size_t line_length(const Ordered& value) { return printed(value).size() + 1; }

/// A line up to its end, or no more than is taken of one; the rest of a longer one is read over.
bool read_line(std::istream& in, std::string& line, bool& too_long) {
  line.clear();
  too_long = false;
  std::streambuf& bytes = *in.rdbuf();
  for (int c = bytes.sbumpc(); c != std::istream::traits_type::eof(); c = bytes.sbumpc()) {
    if (c == '\n') return true;
    too_long = too_long || line.size() == kLongestLine;
    if (!too_long) line += static_cast<char>(c);
  }
  return !line.empty();
}

/// [RFC4648] section 4, with padding.
std::string base64_of(std::string_view bytes) {
  constexpr std::size_t kPiece = 3
                                 << 20;  // the library counts in ints; only the last one is padded
  std::string text;
  for (; !bytes.empty(); bytes.remove_prefix(std::min(kPiece, bytes.size()))) {
    const std::string_view piece = bytes.substr(0, kPiece);
    const std::size_t begin = text.size();
    text.resize(begin + (piece.size() + 2) / 3 * 4 + 1);  // the library ends it with a zero
    EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data() + begin),
                    reinterpret_cast<const unsigned char*>(piece.data()),
                    static_cast<int>(piece.size()));
    text.pop_back();
  }
  return text;
}

class McpServer {
 public:
  McpServer(ApiClient& client, const SceneRoot* files, std::size_t max_bytes)
      : client_(client),
        files_(files),
        max_bytes_(max_bytes),
        tools_(mcp_tools(Ordered::parse(openapi_document()), files != nullptr)) {}

  /// The answer to a line; nothing to what wants none.
  std::optional<Ordered> answer(const std::string& line) {
    if (is_nested_deeply(line)) return fault(nullptr, kParseError, "this is nested too deeply");
    const Json request = Json::parse(line, nullptr, false);
    if (request.is_discarded()) return fault(nullptr, kParseError, "this is no JSON");
    if (!request.is_object()) return fault(nullptr, kInvalidRequest, "a request is one object");
    const Json id = request.value("id", Json());
    const bool good_id = id.is_string() || id.is_number_integer() || id.is_null();
    if (!good_id || request.value("jsonrpc", Json()) != "2.0" || !request.contains("method") ||
        !request["method"].is_string()) {
      return fault(good_id ? id : Json(), kInvalidRequest,
                   "a request has \"jsonrpc\":\"2.0\", a method, and an id of text or number");
    }
    const std::string method = request["method"];
    if (!request.contains("id")) return std::nullopt;  // a notification
    const Json parameters = request.value("params", Json::object());
    if (!parameters.is_object()) return fault(id, kInvalidParams, "params are an object");
    if (method == "initialize") return result(id, introduce(parameters));
    if (method == "ping") return result(id, Ordered::object());
    if (method == "tools/list") return result(id, list());
    if (method == "tools/call") return call(id, parameters);
    return fault(id, kNoSuchMethod, "there is no such method");
  }

 private:
  [[nodiscard]] Ordered introduce(const Json& parameters) const {
    const Json asked = parameters.value("protocolVersion", Json());
    const auto same = std::find_if(kMcpRevisions.begin(), kMcpRevisions.end(),
                                   [&](std::string_view each) { return asked == each; });
    return {
        {"protocolVersion", same == kMcpRevisions.end() ? kMcpRevisions.front() : *same},
        {"capabilities", {{"tools", Ordered::object()}}},
        {"serverInfo", {{"name", "sightline"}, {"version", version()}}},
        {"instructions",
         "Exact answers to rays, points and boxes in 3D scenes. listScenes says what is loaded, "
         "sceneNodes what it is made of. describeTool has the exact schema of a tool. An answer of "
         "more than " +
             std::to_string(max_bytes_) +
             " bytes becomes a summary with the first page; readAnswer has the others."}};
  }
  Ordered list() const {
    Ordered tools = Ordered::array();
    for (const McpTool& tool : tools_) tools.push_back(tool.description);
    return {{"tools", std::move(tools)}};
  }
  Ordered call(const Json& id, const Json& parameters) {
    const Json name = parameters.value("name", Json());
    const Json arguments = parameters.value("arguments", Json::object());
    const auto tool = std::find_if(tools_.begin(), tools_.end(),
                                   [&](const McpTool& each) { return name == each.name; });
    if (tool == tools_.end()) return fault(id, kInvalidParams, "there is no such tool");
    if (Status status = check_mcp_arguments(*tool, arguments); !status) {
      return fault(id, kInvalidParams, status.error().message);
    }
    if (name == kDescribeTool) return describe(id, arguments);
    if (name == kReadAnswer) return read(id, arguments);
    const auto answer = call_mcp_tool(*tool, arguments, client_, files_);
    if (!answer && answer.error().code == "ARGUMENTS_INVALID") {
      return fault(id, kInvalidParams, answer.error().message);
    }
    if (answer && answer->good() && answer->media_type == kPictureType) return picture(id, *answer);
    // What an agent can mend by asking otherwise is told as an answer.
    if (!answer) return result(id, refusal(answer.error()));
    return tell(id, answer->body, !answer->good());
  }
  [[nodiscard]] Ordered describe(const Json& id, const Json& arguments) {
    const Json name = arguments.value("name", Json());
    const auto tool = std::find_if(tools_.begin(), tools_.end(),
                                   [&](const McpTool& each) { return name == each.name; });
    if (tool == tools_.end()) return fault(id, kInvalidParams, "\"name\" has to be that of a tool");
    return tell(id, tool->schema.dump(), false);
  }
  Ordered read(const Json& id, const Json& arguments) {
    const Json answer = arguments.value("answer", Json(pages_.latest()));
    const Json pointer = arguments.value("pointer", Json(""));
    const Json first = arguments.value("first", Json(0U));
    if (!answer.is_number_integer() || !pointer.is_string() || !first.is_number_unsigned()) {
      return fault(id, kInvalidParams,
                   "\"answer\" and \"first\" have to be counts, \"pointer\" a text");
    }
    return tell_page(id, answer.get<int>(), pointer.get<std::string>(), first.get<std::size_t>(),
                     false);
  }
  [[nodiscard]] Ordered picture(const Json& id, const ApiAnswer& answer) const {
    Ordered told = result(
        id, {{"content",
              {{{"type", "image"}, {"data", base64_of(answer.body)}, {"mimeType", kPictureType}}}},
             {"isError", false}});
    if (line_length(told) <= max_bytes_) return told;
    return result(id, refusal({ErrorKind::kTooLarge, "ANSWER_TOO_LONG",
                               "the picture is a line of " + std::to_string(line_length(told)) +
                                   " bytes, the limit is " + std::to_string(max_bytes_) +
                                   " (--max-answer-bytes): ask for a smaller width and height",
                               ""}));
  }
  static Ordered refusal(const Error& error) {
    return content(error.code + ": " + error.message, true);
  }
  /// A text as an answer, and as JSON where it is an object.
  static Ordered content(const std::string& text, bool is_error) {
    Ordered told{{"content", {{{"type", "text"}, {"text", text}}}}, {"isError", is_error}};
    if (!is_nested_deeply(text)) {
      Ordered structured = Ordered::parse(text, nullptr, false);
      if (structured.is_object()) told["structuredContent"] = std::move(structured);
    }
    return told;
  }
  Ordered tell(const Json& id, const std::string& text, bool is_error) {
    if (text.size() <= max_bytes_) {
      Ordered told = result(id, content(text, is_error));
      if (line_length(told) <= max_bytes_) return told;
    }
    return tell_page(id, pages_.add(text), "", 0, is_error);
  }
  /// The line has the page twice: as text, where each quote takes two bytes, and as JSON.
  [[nodiscard]] Ordered tell_page(const Json& id, int answer, const std::string& pointer,
                                  std::size_t first, bool is_error) const {
    for (std::size_t bytes = max_bytes_ / 2;; bytes = bytes * 7 / 8) {
      const auto page = pages_.page(answer, pointer, first, bytes);
      if (!page) return result(id, refusal(page.error()));
      Ordered told = result(id, content(printed(*page), is_error));
      if (line_length(told) <= max_bytes_ || bytes < kLeastPage) return told;
    }
  }

  ApiClient& client_;
  const SceneRoot* files_;
  const std::size_t max_bytes_;
  const std::vector<McpTool> tools_;
  McpPages pages_;
};

}  // namespace

int run_mcp(const McpCommand& command, std::istream& in, std::ostream& out,
            std::ostream& complaints) {
  const auto complain = [&](const Error& error) {
    complaints << "sightline: " << error.code << ": " << error.message << "\n";
    return 2;
  };
  const auto client = ApiClient::open(command.server);
  if (!client) return complain(client.error());
  std::optional<SceneRoot> files;
  if (!command.files.empty()) {
    auto root = SceneRoot::open(command.files);
    if (!root) return complain(root.error());
    files.emplace(std::move(*root));
  }
  McpServer server(**client, files ? &*files : nullptr, command.max_answer_bytes);
  std::string line;
  bool too_long = false;
  while (read_line(in, line, too_long)) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const auto answer =
        too_long ? fault(nullptr, kParseError, "the line is too long") : server.answer(line);
    if (!answer) continue;
    out << printed(*answer) << std::endl;
  }
  return 0;
}

}  // namespace sightline
