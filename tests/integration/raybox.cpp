// Asks a Sightline server where rays meet boxes: a complete client with libcurl.
//
//   c++ -std=c++17 raybox.cpp -lcurl -o raybox && ./raybox http://127.0.0.1:8080
//
// The box and the rays are those of the lectures: from the front, from inside, beside, behind.

#include <curl/curl.h>

#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace {

using Vector = std::array<double, 3>;
struct Ray {
  const char* name;
  Vector origin, direction;
};

/// 17 digits, so that every number arrives as it is, -0 too.
std::string text(const Vector& v) {
  char buffer[96];
  std::snprintf(buffer, sizeof buffer, "[%.17g,%.17g,%.17g]", v[0], v[1], v[2]);
  return buffer;
}

std::size_t append(char* data, std::size_t size, std::size_t count, void* to) {
  static_cast<std::string*>(to)->append(data, size * count);
  return size * count;
}

/// Returns the answer's body, or an empty text after it has said what went wrong.
std::string post(const std::string& url, const std::string& body) {
  const std::unique_ptr<CURL, decltype(&curl_easy_cleanup)> curl(curl_easy_init(),
                                                                 curl_easy_cleanup);
  const std::unique_ptr<curl_slist, decltype(&curl_slist_free_all)> headers(
      curl_slist_append(nullptr, "Content-Type: application/json"), curl_slist_free_all);
  std::string answer;
  curl_easy_setopt(curl.get(), CURLOPT_URL, url.c_str());
  curl_easy_setopt(curl.get(), CURLOPT_HTTPHEADER, headers.get());
  curl_easy_setopt(curl.get(), CURLOPT_POSTFIELDS, body.c_str());
  curl_easy_setopt(curl.get(), CURLOPT_WRITEFUNCTION, append);
  curl_easy_setopt(curl.get(), CURLOPT_WRITEDATA, &answer);
  const CURLcode code = curl_easy_perform(curl.get());
  long status = 0;
  curl_easy_getinfo(curl.get(), CURLINFO_RESPONSE_CODE, &status);
  if (code == CURLE_OK && status == 200) return answer;
  std::fprintf(stderr, "%s: %s\n", url.c_str(),
               code == CURLE_OK ? answer.c_str() : curl_easy_strerror(code));
  return {};
}

/// The results one by one: each is an object without objects inside.
std::vector<std::string> results(const std::string& answer) {
  std::vector<std::string> found;
  for (std::size_t at = answer.find('[') + 1; (at = answer.find('{', at)) != std::string::npos;) {
    const std::size_t end = answer.find('}', at) + 1;
    found.push_back(answer.substr(at, end - at));
    at = end;
  }
  return found;
}

}  // namespace

int main(int count, char** arguments) {
  const std::string url = count > 1 ? arguments[1] : "http://127.0.0.1:8080";
  const std::vector<Ray> rays{{"from the front", {-10, 0, 0}, {1, 0.015625, 0.015625}},
                              {"from inside", {0, 0, 0}, {-1, -0.5, -0.25}},
                              {"in a face", {-10, 3, 0}, {1, -0.0, 0}},
                              {"beside", {-10, 5, 0}, {1, 0, 0}},
                              {"behind", {10, 0, 0}, {1, 0, 0}}};
  std::string body = R"({"pairing":"all","boxes":[{"min":[-2,-3,-4],"max":[4,3,2]}],"rays":[)";
  for (const Ray& ray : rays) {
    body += std::string(&ray == &rays[0] ? "" : ",") + "{\"origin\":" + text(ray.origin) +
            ",\"direction\":" + text(ray.direction) + "}";
  }
  curl_global_init(CURL_GLOBAL_DEFAULT);
  const std::vector<std::string> answers = results(post(url + "/v1/rays-boxes", body + "]}"));
  curl_global_cleanup();
  if (answers.size() != rays.size()) return 1;
  for (std::size_t i = 0; i < rays.size(); ++i)
    std::printf("%s: %s\n", rays[i].name, answers[i].c_str());
  return 0;
}
