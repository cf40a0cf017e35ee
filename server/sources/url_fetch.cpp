#include "server/sources/url_fetch.h"

#include <curl/curl.h>
#include <sys/socket.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "core/store/scene_load.h"

namespace sightline {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kConnect{10'000};
/// Of what is not the scene: heads, and the bodies of redirects and errors.
constexpr std::size_t kMostHead = 64 << 10;
/// A source that sends less than this for so long is given up.
constexpr long kLeastBytesPerSecond = 100, kLeastForSeconds = 30;

Error source_error(const char* code, std::string message) {
  return {ErrorKind::kInvalid, code, std::move(message), ""};
}

/// One request and what became of it.
struct Transfer {
  const UrlRules& rules;
  const UrlReceiver& receiver;
  const std::uint64_t limit;
  CURL* easy = nullptr;
  std::uint64_t size = 0;
  std::size_t head_bytes = 0;
  bool expected = false;
  bool address_refused = false;
  std::optional<Error> refused = {};

  long status() const {
    long code = 0;
    curl_easy_getinfo(easy, CURLINFO_RESPONSE_CODE, &code);
    return code;
  }
};

// What follows is called by libcurl, from C: no exception may leave.

curl_socket_t open_socket(void* data, curlsocktype, curl_sockaddr* address) {
  auto& transfer = *static_cast<Transfer*>(data);
  const auto ip = IpAddress::of(&address->addr);
  const auto& ranges = transfer.rules.addresses;
  const bool allowed =
      ip && (is_public(*ip) || std::any_of(ranges.begin(), ranges.end(), [&](const auto& range) {
               return range.contains(*ip) || range.contains(ip->unmapped());
             }));
  if (!allowed) {
    transfer.address_refused = true;
    return CURL_SOCKET_BAD;
  }
  return ::socket(address->family, address->socktype | SOCK_CLOEXEC, address->protocol);
}

std::size_t take_head(char*, std::size_t, std::size_t size, void* data) {
  auto& transfer = *static_cast<Transfer*>(data);
  transfer.head_bytes += size;
  return transfer.head_bytes > kMostHead ? 0 : size;
}

std::size_t take_body(char* bytes, std::size_t, std::size_t size, void* data) {
  auto& transfer = *static_cast<Transfer*>(data);
  if (transfer.status() != 200) {
    transfer.head_bytes += size;
    return transfer.head_bytes > kMostHead ? 0 : size;
  }
  try {
    if (!transfer.expected) {
      transfer.expected = true;
      curl_off_t length = -1;
      curl_easy_getinfo(transfer.easy, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
      if (length > 0) transfer.receiver.expect(static_cast<std::uint64_t>(length));
    }
    transfer.size += size;
    Status status = transfer.size > transfer.limit
                        ? source_too_large(transfer.limit)
                        : transfer.receiver.take(std::as_bytes(std::span(bytes, size)));
    if (status) return size;
    transfer.refused = std::move(status).error();
  } catch (...) {
    transfer.refused = {ErrorKind::kOutOfSpace, "MEMORY_FULL",
                        "there is no memory left for the scene", ""};
  }
  return 0;
}

int look(void* data, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
  return static_cast<Transfer*>(data)->receiver.cancelled() ? 1 : 0;
}

Error error_of(CURLcode code, const Transfer& transfer) {
  if (transfer.refused) return *transfer.refused;
  switch (code) {
    case CURLE_ABORTED_BY_CALLBACK:
      return load_cancelled();
    case CURLE_FILESIZE_EXCEEDED:
      return source_too_large(transfer.limit);
    case CURLE_OPERATION_TIMEDOUT:
      return source_error("SOURCE_TOO_SLOW", "the url's server did not send the file in time");
    case CURLE_COULDNT_RESOLVE_HOST:
      return source_error("SOURCE_UNREACHABLE", "the url's host has no address");
    case CURLE_PEER_FAILED_VERIFICATION:
    case CURLE_SSL_CONNECT_ERROR:
      return source_error("SOURCE_UNREACHABLE", "the url's server has no valid certificate (TLS)");
    case CURLE_WRITE_ERROR:
      return source_error("SOURCE_ANSWER", "the url's server answered with too much beside a file");
    default:
      return source_error("SOURCE_UNREACHABLE", "the url's server cannot be reached, or broke off");
  }
}

struct FreeEasy {
  void operator()(CURL* easy) const { curl_easy_cleanup(easy); }
};

void set_options(CURL* easy, Transfer& transfer, const SourceUrl& url, Clock::time_point end) {
  const auto left =
      std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
  curl_easy_setopt(easy, CURLOPT_CURLU, url.handle());
  curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy, CURLOPT_HTTP_VERSION, CURL_HTTP_VERSION_1_1);
  // What the environment says of proxies would make the check of the address one of the proxy's.
  curl_easy_setopt(easy, CURLOPT_PROXY, "");
  curl_easy_setopt(easy, CURLOPT_NETRC, CURL_NETRC_IGNORED);
  curl_easy_setopt(easy, CURLOPT_FOLLOWLOCATION, 0L);
  curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
  // A name server that says nothing would hold this thread, and a stop, beyond every time limit:
  // the library waits for the thread that asks it.
  curl_easy_setopt(easy, CURLOPT_QUICK_EXIT, 1L);
  curl_easy_setopt(easy, CURLOPT_USERAGENT, transfer.rules.agent.c_str());
  curl_easy_setopt(easy, CURLOPT_TIMEOUT_MS, static_cast<long>(std::max<long long>(left, 1)));
  curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(kConnect.count()));
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_LIMIT, kLeastBytesPerSecond);
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_TIME, kLeastForSeconds);
  curl_easy_setopt(easy, CURLOPT_MAXFILESIZE_LARGE,
                   static_cast<curl_off_t>(std::min<std::uint64_t>(transfer.limit, 1ull << 62)));
  curl_easy_setopt(easy, CURLOPT_OPENSOCKETFUNCTION, &open_socket);
  curl_easy_setopt(easy, CURLOPT_OPENSOCKETDATA, &transfer);
  curl_easy_setopt(easy, CURLOPT_HEADERFUNCTION, &take_head);
  curl_easy_setopt(easy, CURLOPT_HEADERDATA, &transfer);
  curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, &take_body);
  curl_easy_setopt(easy, CURLOPT_WRITEDATA, &transfer);
  curl_easy_setopt(easy, CURLOPT_XFERINFOFUNCTION, &look);
  curl_easy_setopt(easy, CURLOPT_XFERINFODATA, &transfer);
  curl_easy_setopt(easy, CURLOPT_NOPROGRESS, 0L);
}

}  // namespace

Error url_not_allowed() {
  return source_error("URL_NOT_ALLOWED",
                      "the server's --allow-url patterns do not allow this url, or one that it "
                      "was redirected to");
}

Status fetch_url(SourceUrl url, const UrlRules& rules, std::uint64_t limit,
                 const UrlReceiver& receiver) {
  const auto end = Clock::now() + rules.time;
  for (int redirects = 0;; ++redirects) {
    if (!matches_any(rules.patterns, url)) return url_not_allowed();
    const std::unique_ptr<CURL, FreeEasy> easy(curl_easy_init());
    if (!easy) return source_error("SOURCE_UNREACHABLE", "no request could be made");
    Transfer transfer{rules, receiver, limit, easy.get()};
    set_options(easy.get(), transfer, url, end);
    const CURLcode code = curl_easy_perform(easy.get());
    if (code != CURLE_OK && transfer.address_refused && transfer.status() == 0) {
      return source_error("ADDRESS_REFUSED",
                          "the url's host is not at a public address, and no --allow-address of "
                          "the server allows it");
    }
    if (code != CURLE_OK) return error_of(code, transfer);
    const long status = transfer.status();
    if (status == 200) return success();
    const char* location = nullptr;
    curl_easy_getinfo(easy.get(), CURLINFO_REDIRECT_URL, &location);
    if (status < 300 || status > 399 || location == nullptr) {
      return source_error("SOURCE_ANSWER",
                          "the url's server answered with status " + std::to_string(status));
    }
    if (redirects == kMostRedirects) {
      return source_error("REDIRECTS_TOO_MANY", "the url redirects more than " +
                                                    std::to_string(kMostRedirects) + " times");
    }
    auto next = SourceUrl::parse(location);
    if (!next) return std::move(next).error();
    url = std::move(*next);
  }
}

}  // namespace sightline
