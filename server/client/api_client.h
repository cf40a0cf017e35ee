#pragma once
/// ApiClient: a client of a Sightline server.

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "server/operation/cli.h"

namespace httplib {
class Client;
}

namespace sightline {

/// Names and values of headers.
using ApiHeaders = std::vector<std::pair<std::string, std::string>>;

/// An answer of the server.
struct ApiAnswer {
  int status = 0;
  std::string body;
  std::string media_type = {};  ///< without its parameters; empty if the server states none
  bool good() const { return status < 400; }
};

/// Sends requests to one server, with a key. Its connection is made by the first request, and
/// reused between requests. Not thread-safe.
class ApiClient {
 public:
  /// Makes a client; connects to nothing yet. Errors: URL_INVALID (not http://HOST[:PORT][/PREFIX]
  /// or https://...), KEY_UNREADABLE.
  static Result<std::unique_ptr<ApiClient>> open(const ServerAddress& server);
  ~ApiClient();
  ApiClient(const ApiClient&) = delete;
  ApiClient& operator=(const ApiClient&) = delete;

  /// Sends a request and returns the answer, whatever its status. Waits for the answer, for at most
  /// ten minutes without a byte. `path` includes the query and is percent-encoded. Errors:
  /// SERVER_UNREACHABLE; the next call connects again.
  Result<ApiAnswer> ask(const std::string& method, const std::string& path,
                        const std::string& body = {}, const std::string& media_type = {},
                        const ApiHeaders& headers = {});

 private:
  ApiClient(std::unique_ptr<httplib::Client> client, std::string prefix);
  std::unique_ptr<httplib::Client> client_;
  std::string prefix_;
};

/// Encodes a text for a segment of a path, or for the value of a parameter.
std::string percent_encoded(std::string_view text);

/// Replaces control characters by "?" in a text of another program, for a terminal.
std::string printable(std::string_view text);

/// The message of an error answer, for people: "404 SCENE_NOT_FOUND: ...", or the status alone if
/// the body is no problem+json.
std::string problem_text(const ApiAnswer& answer);

}  // namespace sightline

// Tests: tests/integration/query_test.py
