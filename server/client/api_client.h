#pragma once
/// A server of Sightline, seen from a client.

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

/// Names and values.
using ApiHeaders = std::vector<std::pair<std::string, std::string>>;

struct ApiAnswer {
  int status = 0;
  std::string body;
  std::string media_type = {};  ///< without its parameters; empty where the server says none
  bool good() const { return status < 400; }
};

/// One connection that is reused between requests. For one thread.
class ApiClient {
 public:
  /// Errors: URL_INVALID (not http://HOST[:PORT][/PREFIX] or https://...), KEY_UNREADABLE.
  static Result<std::unique_ptr<ApiClient>> open(const ServerAddress& server);
  ~ApiClient();
  ApiClient(const ApiClient&) = delete;
  ApiClient& operator=(const ApiClient&) = delete;

  /// `path` with its query, percent-encoded. Errors: SERVER_UNREACHABLE.
  Result<ApiAnswer> ask(const std::string& method, const std::string& path,
                        const std::string& body = {}, const std::string& media_type = {},
                        const ApiHeaders& headers = {});

 private:
  ApiClient(std::unique_ptr<httplib::Client> client, std::string prefix);
  std::unique_ptr<httplib::Client> client_;
  std::string prefix_;
};

/// One segment of a path, or the value of a parameter.
std::string percent_encoded(std::string_view text);

/// Text of another program for a terminal: without control characters.
std::string printable(std::string_view text);

/// The message of an answer that is an error, for people.
std::string problem_text(const ApiAnswer& answer);

}  // namespace sightline
