#include "server/client/api_client.h"

#include <httplib.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/store/posix_file.h"
#include "server/operation/version.h"
#include "server/sources/source_url.h"

namespace sightline {
namespace {

constexpr std::chrono::seconds kConnectTime{10}, kAnswerTime{600};
constexpr std::size_t kMostKeyBytes = 4096;
/// Of an answer, which is held in memory; the server's own limits are lower.
constexpr std::size_t kMostAnswerBytes = std::size_t{4} << 30;

Result<std::string> key_of(const ServerAddress& server) {
  std::string key;
  if (!server.key_file.empty()) {
    auto text = read_small_file(server.key_file, kMostKeyBytes, "read the key");
    if (!text) {
      return Error{ErrorKind::kNotFound, "KEY_UNREADABLE",
                   "--key-file " + server.key_file + ": " + text.error().message, ""};
    }
    key = std::move(*text);
  } else if (const char* found = std::getenv("SIGHTLINE_KEY"); found != nullptr) {
    key = found;
  }
  key.erase(key.find_last_not_of(" \t\r\n") + 1);
  const bool is_printable =
      std::all_of(key.begin(), key.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (is_printable) return key;
  return Error{ErrorKind::kInvalid, "KEY_UNREADABLE", "the key has characters that no key has", ""};
}

/// The library's own texts name its constants.
const char* reason_of(httplib::Error error) {
  switch (error) {
    case httplib::Error::Connection:
      return "nothing takes connections at this address and port, or its name is unknown";
    case httplib::Error::ConnectionTimeout:
      return "the connection could not be made in ten seconds";
    case httplib::Error::Read:
      return "it ended the connection, said nothing for ten minutes, or does not speak HTTP";
    case httplib::Error::Write:
      return "it ended the connection before it had the whole question";
    case httplib::Error::Canceled:
      return "its answer is longer than it may be";
    case httplib::Error::SSLConnection:
      return "it does not speak TLS as this client does";
    case httplib::Error::SSLLoadingCerts:
      return "the certificates of authorities cannot be read (SSL_CERT_FILE)";
    case httplib::Error::SSLServerVerification:
      return "no authority that this machine trusts has signed its certificate, or not for this "
             "name (SSL_CERT_FILE names authorities of your own)";
    default:
      return "the exchange with it failed";
  }
}

}  // namespace

ApiClient::ApiClient(std::unique_ptr<httplib::Client> client, std::string prefix)
    : client_(std::move(client)), prefix_(std::move(prefix)) {}
ApiClient::~ApiClient() = default;

Result<std::unique_ptr<ApiClient>> ApiClient::open(const ServerAddress& server) {
  const auto url = SourceUrl::parse(server.url);
  if (!url) return url.error();
  auto key = key_of(server);
  if (!key) return std::move(key).error();
  auto client = std::make_unique<httplib::Client>(url->scheme + "://" + url->host + ":" +
                                                  std::to_string(url->port));
  client->set_connection_timeout(kConnectTime);
  client->set_read_timeout(kAnswerTime);
  client->set_write_timeout(kAnswerTime);
  client->set_keep_alive(true);
  client->set_tcp_nodelay(true);
  client->set_url_encode(false);
  httplib::Headers headers{{"User-Agent", "sightline/" + std::string(version())}};
  if (!key->empty()) headers.emplace("Authorization", "Bearer " + *key);
  client->set_default_headers(headers);
  std::string prefix = url->path;
  while (prefix.ends_with('/')) prefix.pop_back();
  return std::unique_ptr<ApiClient>(new ApiClient(std::move(client), std::move(prefix)));
}

Result<ApiAnswer> ApiClient::ask(const std::string& method, const std::string& path,
                                 const std::string& body, const std::string& media_type,
                                 const ApiHeaders& headers) {
  httplib::Request request;
  request.method = method;
  request.path = prefix_ + path;
  request.body = body;
  if (!media_type.empty()) request.set_header("Content-Type", media_type);
  for (const auto& [name, value] : headers) request.set_header(name, value);
  std::string told;
  request.content_receiver = [&](const char* data, std::size_t size, std::uint64_t, std::uint64_t) {
    if (size > kMostAnswerBytes - told.size()) return false;
    told.append(data, size);
    return true;
  };
  const auto answer = client_->send(request);
  if (answer) {
    const std::string type = answer->get_header_value("Content-Type");
    return ApiAnswer{answer->status, std::move(told), type.substr(0, type.find(';'))};
  }
  return Error{ErrorKind::kNotFound, "SERVER_UNREACHABLE",
               std::string("the server does not answer: ") + reason_of(answer.error()), ""};
}

std::string percent_encoded(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_plain = (byte >= '0' && byte <= '9') || (byte >= 'A' && byte <= 'Z') ||
                          (byte >= 'a' && byte <= 'z') ||
                          std::string_view("-._~").find(c) != std::string_view::npos;
    if (is_plain) {
      encoded += c;
    } else {
      encoded += '%';
      encoded += kDigits[byte >> 4];
      encoded += kDigits[byte & 15];
    }
  }
  return encoded;
}

std::string printable(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    // U+0080 to U+009F are two bytes, and controls as well.
    const bool is_upper = byte == 0xc2 && i + 1 < text.size() &&
                          static_cast<unsigned char>(text[i + 1]) >= 0x80 &&
                          static_cast<unsigned char>(text[i + 1]) < 0xa0;
    if (is_upper) ++i;
    out += is_upper || byte < 0x20 || byte == 0x7f ? '?' : text[i];
  }
  return out;
}

std::string problem_text(const ApiAnswer& answer) {
  using Json = nlohmann::json;
  const Json problem = Json::parse(answer.body, nullptr, false);
  const auto text_of = [](const Json& object, const char* key) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    return found != object.end() && found->is_string() ? found->get<std::string>() : "";
  };
  std::string text = std::to_string(answer.status);
  if (!problem.is_object()) return text;
  text += " " + text_of(problem, "code") + ": " + text_of(problem, "detail");
  const auto errors = problem.find("errors");
  if (errors != problem.end() && errors->is_array() && !errors->empty()) {
    const std::string pointer = text_of(errors->front(), "pointer");
    if (!pointer.empty()) text += " at " + pointer;
  }
  return printable(text);
}

}  // namespace sightline
