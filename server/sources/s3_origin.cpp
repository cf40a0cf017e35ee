#include "server/sources/s3_origin.h"

#include <curl/curl.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <pugixml.hpp>
#include <thread>

namespace sightline {
namespace {

constexpr std::chrono::milliseconds kConnectToStore{3'000};
/// A store that sends or takes less than this for so long is given up.
constexpr long kLeastRate = 100, kLeastRateFor = 10;
constexpr int kRepeats = 2;
constexpr std::chrono::milliseconds kFirstPause{100};
constexpr std::size_t kMostText = 4 << 20;  ///< of a listing or of an error
constexpr std::size_t kMostIdle = 16;
constexpr std::size_t kPage = 1000;

Error unreachable(const std::string& why) {
  return {ErrorKind::kBusy, "ORIGIN_UNREACHABLE", "the origin cannot be reached: " + why, ""};
}

/// The characters of names need no encoding but for '/' in a query.
std::string in_query(std::string_view text) {
  std::string encoded;
  for (const char c : text) {
    if (c == '/') {
      encoded += "%2F";
    } else {
      encoded += c;
    }
  }
  return encoded;
}

}  // namespace

/// A handle of libcurl, which retains its connection.
class S3Origin::Connection {
 public:
  Connection() : easy_(curl_easy_init()) {}
  ~Connection() { curl_easy_cleanup(easy_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  CURL* easy() const { return easy_; }

 private:
  CURL* easy_;
};

/// One request and what became of it.
struct S3Origin::Request {
  const char* method = "GET";
  std::string path;   ///< after the bucket: "" or "/name"
  std::string query;  ///< sorted by name and encoded, as the signature needs it
  std::vector<std::string> headers = {};
  std::string_view content = {};         ///< of a PUT
  const FileDescriptor* file = nullptr;  ///< of a PUT; not null: instead of `content`
  std::uint64_t bytes = 0;               ///< of the file
  /// Receives the body of an answer of status 200; null: it is stored in `text`.
  const std::function<Status(std::span<const std::byte>)>* sink = nullptr;

  CURL* easy = nullptr;
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::string text = {};
  std::optional<Error> refused = {};

  long status() const {
    long code = 0;
    curl_easy_getinfo(easy, CURLINFO_RESPONSE_CODE, &code);
    return code;
  }
};

namespace {

// What follows is called by libcurl, from C: no exception may leave.

template <class Request>
std::size_t give_body(char* to, std::size_t, std::size_t size, void* data) {
  auto& request = *static_cast<Request*>(data);
  if (request.file != nullptr) {
    const auto room =
        static_cast<std::size_t>(std::min<std::uint64_t>(size, request.bytes - request.sent));
    const auto got = read_at(*request.file, request.sent,
                             std::as_writable_bytes(std::span(to, room)), "write to the origin");
    if (!got || *got != room) return CURL_READFUNC_ABORT;
    request.sent += room;
    return room;
  }
  const std::string_view rest = request.content.substr(static_cast<std::size_t>(request.sent));
  const std::size_t room = std::min(size, rest.size());
  std::copy_n(rest.data(), room, to);
  request.sent += room;
  return room;
}

/// A body is sent again if a reused connection turns out to be closed.
template <class Request>
int rewind_body(void* data, curl_off_t offset, int origin) {
  if (origin != SEEK_SET || offset < 0) return CURL_SEEKFUNC_CANTSEEK;
  static_cast<Request*>(data)->sent = static_cast<std::uint64_t>(offset);
  return CURL_SEEKFUNC_OK;
}

template <class Request>
std::size_t take_answer(char* bytes, std::size_t, std::size_t size, void* data) {
  auto& request = *static_cast<Request*>(data);
  try {
    request.received += size;
    if (request.sink != nullptr && request.status() == 200) {
      Status status = (*request.sink)(std::as_bytes(std::span(bytes, size)));
      if (status) return size;
      request.refused = std::move(status).error();
      return 0;
    }
    if (request.text.size() + size > kMostText) return 0;
    request.text.append(bytes, size);
    return size;
  } catch (...) {
    return 0;
  }
}

/// The error of a status that none of the functions expects. `text` is the body of the answer.
Error error_of_status(long status, const std::string& text) {
  std::string code;
  pugi::xml_document document;
  if (document.load_buffer(text.data(), text.size())) {
    code = document.child("Error").child_value("Code");
  }
  const bool is_plain =
      !code.empty() && code.size() <= 64 && std::all_of(code.begin(), code.end(), [](char c) {
        return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
      });
  const std::string what = std::to_string(status) + (is_plain ? " " + code : "");
  if (status >= 500 || status == 429) return unreachable("it answers " + what);
  if (status == 401 || status == 403 || status == 404 || status == 301 || status == 400) {
    return {ErrorKind::kInternal, "ORIGIN_REFUSED",
            "the origin refuses the request with status " + what +
                ": check its address, its bucket and the credentials",
            ""};
  }
  return {ErrorKind::kInternal, "ORIGIN_ANSWER", "the origin answers with status " + what, ""};
}

struct FreeList {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};

}  // namespace

S3Origin::S3Origin(S3Bucket bucket) : bucket_(std::move(bucket)) {}
S3Origin::~S3Origin() = default;

Result<long> S3Origin::send(Request& request) {
  std::unique_ptr<Connection> connection;
  {
    const std::lock_guard hold(mutex_);
    if (!idle_.empty()) {
      connection = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (!connection) connection = std::make_unique<Connection>();
  CURL* const easy = connection->easy();
  if (easy == nullptr) return unreachable("no request could be made");
  curl_easy_reset(easy);
  request.easy = easy;

  std::string url = bucket_.endpoint + "/" + bucket_.bucket + request.path;
  if (!request.query.empty()) url += "?" + request.query;
  std::unique_ptr<curl_slist, FreeList> headers;
  const auto add_header = [&](const std::string& line) {
    headers.reset(curl_slist_append(headers.release(), line.c_str()));
  };
  for (const std::string& line : request.headers) add_header(line);
  add_header("x-amz-content-sha256: UNSIGNED-PAYLOAD");
  if (!bucket_.token.empty()) add_header("x-amz-security-token: " + bucket_.token);

  curl_easy_setopt(easy, CURLOPT_URL, url.c_str());
  curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy, CURLOPT_HTTP_VERSION, CURL_HTTP_VERSION_1_1);
  curl_easy_setopt(easy, CURLOPT_NETRC, CURL_NETRC_IGNORED);
  curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(easy, CURLOPT_QUICK_EXIT, 1L);
  curl_easy_setopt(easy, CURLOPT_USERAGENT, "sightline");
  curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(kConnectToStore.count()));
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_LIMIT, kLeastRate);
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_TIME, kLeastRateFor);
  const std::string signature = "aws:amz:" + bucket_.region + ":s3";
  curl_easy_setopt(easy, CURLOPT_AWS_SIGV4, signature.c_str());
  curl_easy_setopt(easy, CURLOPT_USERNAME, bucket_.key_id.c_str());
  curl_easy_setopt(easy, CURLOPT_PASSWORD, bucket_.secret.c_str());
  const bool has_body = std::string_view(request.method) == "PUT";
  if (has_body) {
    const std::uint64_t size = request.file != nullptr ? request.bytes : request.content.size();
    curl_easy_setopt(easy, CURLOPT_UPLOAD, 1L);
    curl_easy_setopt(easy, CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(size));
    curl_easy_setopt(easy, CURLOPT_READFUNCTION, &give_body<Request>);
    curl_easy_setopt(easy, CURLOPT_READDATA, &request);
    curl_easy_setopt(easy, CURLOPT_SEEKFUNCTION, &rewind_body<Request>);
    curl_easy_setopt(easy, CURLOPT_SEEKDATA, &request);
  } else if (std::string_view(request.method) == "HEAD") {
    curl_easy_setopt(easy, CURLOPT_NOBODY, 1L);
  } else {
    curl_easy_setopt(easy, CURLOPT_CUSTOMREQUEST, request.method);
  }
  curl_easy_setopt(easy, CURLOPT_HTTPHEADER, headers.get());
  curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, &take_answer<Request>);
  curl_easy_setopt(easy, CURLOPT_WRITEDATA, &request);

  const CURLcode code = curl_easy_perform(easy);
  const long status = request.status();
  if (request.refused) return *request.refused;
  // A store that refuses a body early may end the connection before it has taken all of it.
  const bool is_answered = has_body && status >= 400;
  if (code != CURLE_OK && !is_answered) return unreachable(curl_easy_strerror(code));
  if (code == CURLE_OK) {
    const std::lock_guard hold(mutex_);
    if (idle_.size() < kMostIdle) idle_.push_back(std::move(connection));
  }
  return status;
}

Result<long> S3Origin::send_again(Request& request) {
  auto pause = kFirstPause;
  for (int repeat = 0;; ++repeat) {
    auto status = send(request);
    const bool is_lost =
        status ? *status >= 500 || *status == 429 : status.error().code == "ORIGIN_UNREACHABLE";
    // What the sink has taken cannot be taken back.
    if (!is_lost || repeat == kRepeats || (request.sink != nullptr && request.received > 0)) {
      return status;
    }
    request.text.clear();
    request.received = 0;
    std::this_thread::sleep_for(pause);
    pause *= 4;
  }
}

Result<bool> S3Origin::create(const std::string& name, std::string_view content) {
  Request request{"PUT", "/" + bucket_.prefix + name, "", {"If-None-Match: *"}, content};
  const auto status = send(request);
  if (!status) return status.error();
  if (*status == 200 || *status == 201 || *status == 204) return true;
  // 409: another writer is about to create it.
  if (*status == 412 || *status == 409) return false;
  return error_of_status(*status, request.text);
}

Result<bool> S3Origin::create(const std::string& name, const FileDescriptor& file,
                              std::uint64_t bytes) {
  // It is there more often than not when a scene is sent again, and may be large.
  Request head{"HEAD", "/" + bucket_.prefix + name, ""};
  const auto there = send_again(head);
  if (!there) return there.error();
  if (*there == 200) return false;
  Request request{"PUT", "/" + bucket_.prefix + name, "", {"If-None-Match: *"}, {}, &file, bytes};
  const auto status = send(request);
  if (!status) return status.error();
  if (*status == 200 || *status == 201 || *status == 204) return true;
  if (*status == 412 || *status == 409) return false;
  return error_of_status(*status, request.text);
}

Result<bool> S3Origin::read(const std::string& name,
                            const std::function<Status(std::span<const std::byte>)>& sink) {
  Request request{"GET", "/" + bucket_.prefix + name, ""};
  request.sink = &sink;
  const auto status = send_again(request);
  if (!status) return status.error();
  if (*status == 200) return true;
  // 404 is also the answer for a bucket that is not there.
  if (*status == 404 && request.text.find("NoSuchBucket") == std::string::npos) return false;
  return error_of_status(*status, request.text);
}

Result<std::vector<OriginObject>> S3Origin::list(const std::string& prefix,
                                                 const std::string& after) {
  std::vector<OriginObject> objects;
  std::string start = after.empty() ? "" : bucket_.prefix + after;
  for (;;) {
    Request request;
    request.query = "list-type=2&max-keys=" + std::to_string(kPage) +
                    "&prefix=" + in_query(bucket_.prefix + prefix);
    if (!start.empty()) request.query += "&start-after=" + in_query(start);
    const auto status = send_again(request);
    if (!status) return status.error();
    if (*status != 200) return error_of_status(*status, request.text);
    pugi::xml_document document;
    const bool is_xml =
        static_cast<bool>(document.load_buffer(request.text.data(), request.text.size()));
    const pugi::xml_node result = document.child("ListBucketResult");
    if (!is_xml || !result) {
      return Error{ErrorKind::kInternal, "ORIGIN_ANSWER", "the origin answers with no listing", ""};
    }
    const std::string last = start;
    for (const pugi::xml_node each : result.children("Contents")) {
      const std::string key = each.child_value("Key");
      if (!key.starts_with(bucket_.prefix + prefix)) continue;
      objects.push_back({key.substr(bucket_.prefix.size()), each.child("Size").text().as_ullong()});
      start = std::max(start, key);
    }
    if (std::string_view(result.child_value("IsTruncated")) != "true") break;
    if (start == last) {
      return Error{ErrorKind::kInternal, "ORIGIN_ANSWER", "the origin's listing does not end", ""};
    }
  }
  std::sort(objects.begin(), objects.end(),
            [](const OriginObject& a, const OriginObject& b) { return a.name < b.name; });
  return objects;
}

Status S3Origin::remove(const std::string& name) {
  Request request{"DELETE", "/" + bucket_.prefix + name, ""};
  const auto status = send_again(request);
  if (!status) return status.error();
  if (*status == 200 || *status == 204 || *status == 404) return success();
  return error_of_status(*status, request.text);
}

}  // namespace sightline
