#include "server/client/commands.h"

#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/base/infinity.h"
#include "proto/json/hit_lines.h"
#include "proto/json/json_parts.h"
#include "server/client/api_client.h"
#include "server/client/json_depth.h"

namespace sightline {
namespace {

using Ordered = nlohmann::ordered_json;

constexpr int kExitGood = 0, kExitMiss = 1, kExitError = 2;
/// Rays that are asked for together: what bounds the memory of a file of any length.
constexpr std::size_t kRaysAtOnce = 10'000;

std::string line_of(const Ray& ray) {
  JsonWriter out(256);
  write(out, "{\"origin\":", ray.origin, ",\"direction\":", ray.direction, ",\"tmin\":", ray.tmin,
        ",\"tmax\":", ray.tmax, "}\n");
  return out.take();
}

/// The numbers of a line, between blanks or commas. Empty for what is none.
std::vector<double> numbers_of(std::string_view line) {
  constexpr std::string_view kSeparators = " \t\r,;";
  std::vector<double> numbers;
  for (;;) {
    line.remove_prefix(std::min(line.find_first_not_of(kSeparators), line.size()));
    if (line.empty()) return numbers;
    double number = 0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), number);
    const auto length = static_cast<std::size_t>(end - line.data());
    if (error != std::errc() ||
        (length < line.size() && kSeparators.find(line[length]) == std::string_view::npos)) {
      return {};
    }
    numbers.push_back(number);
    line.remove_prefix(length);
  }
}

/// A line of a file of rays as a line for the server; empty for one that says nothing.
Result<std::string> ray_line(const std::string& line, std::size_t number) {
  const std::size_t begin = line.find_first_not_of(" \t\r");
  if (begin == std::string::npos || line[begin] == '#') return std::string();
  if (line[begin] == '{') return line + "\n";
  const auto numbers = numbers_of(line);
  if (numbers.size() < 6 || numbers.size() > 8) {
    return Error{ErrorKind::kInvalid, "RAY_LINE_INVALID",
                 "line " + std::to_string(number) +
                     ": a ray has six numbers, and one or two more for its limits",
                 ""};
  }
  Ray ray;
  for (int k = 0; k < 3; ++k) {
    ray.origin[k] = numbers[static_cast<std::size_t>(k)];
    ray.direction[k] = numbers[static_cast<std::size_t>(k) + 3];
  }
  if (numbers.size() > 6) ray.tmin = numbers[6];
  if (numbers.size() > 7) ray.tmax = numbers[7];
  return line_of(ray);
}

std::string options_line(const QueryCommand& command) {
  Ordered options = Ordered::object();
  if (command.fields) {
    for (const HitField field : all_hit_fields()) {
      if (command.fields->has(field)) options["fields"].push_back(hit_field_name(field));
    }
  }
  const bool lists = command.mode == CastMode::kAll || command.mode == CastMode::kCount;
  if (lists && command.crossings == Crossings::kOnce) options["crossings"] = "once";
  return Ordered{{"options", options}}.dump() + "\n";
}

std::string_view kind_of(CastMode mode) {
  constexpr std::string_view kKinds[] = {"closest", "any", "all", "count"};
  return kKinds[static_cast<std::size_t>(mode)];
}

/// "t=8  node=\"left\"", or "miss".
std::string hit_text(const Ordered& hit) {
  if (hit.is_null()) return "miss";
  if (!hit.is_object()) return printable(hit.dump());
  std::string text;
  for (const auto& [name, value] : hit.items()) {
    text += (text.empty() ? "" : "  ") + name + "=" + value.dump();
  }
  return printable(text);
}

/// One answer for people: lists have a line for each hit, below their total.
std::string answer_text(const Ordered& answer) {
  if (!answer.is_object() || !answer.contains("hits")) return hit_text(answer) + "\n";
  std::string text = printable(answer.value("total", Ordered()).dump()) + " hits\n";
  for (const Ordered& hit : answer["hits"]) text += "  " + hit_text(hit) + "\n";
  return text;
}

/// Whether an answer says that there is nothing.
bool is_miss(const Ordered& answer) {
  return answer.is_null() || answer == false || answer == 0 ||
         (answer.is_object() && answer.value("total", Ordered()) == 0);
}

/// Of a line that is no answer to a ray.
std::string last_words(const Ordered& told, std::string_view line) {
  constexpr std::size_t kShown = 500;
  const auto status = told.is_object() ? told.find("status") : told.end();
  if (status != told.end() && status->is_number_integer()) {
    return problem_text({status->get<int>(), std::string(line)});
  }
  // Quoted, since it may be anything.
  JsonWriter out(kShown + 64);
  out.string(line.substr(0, kShown));
  return printable(out.take());
}

/// Sends rays and prints what comes back.
class Asker {
 public:
  Asker(const QueryCommand& command, ApiClient& client, std::ostream& out)
      : command_(command),
        client_(client),
        out_(out),
        path_("/v1/scenes/" + percent_encoded(command.scene) +
              "/rays:" + std::string(kind_of(command.mode))),
        options_(options_line(command)) {}

  /// Precondition: `lines` are `count` rays.
  Status ask(const std::string& lines, std::size_t count) {
    const auto answer = client_.ask("POST", path_, options_ + lines, std::string(kLinesMediaType));
    if (!answer) return answer.error();
    if (!answer->good()) {
      return Error{ErrorKind::kInvalid, "SERVER_REFUSES", problem_text(*answer), ""};
    }
    std::string_view rest = answer->body;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t end = rest.find('\n');
      const std::string_view line = rest.substr(0, end);
      rest.remove_prefix(std::min(line.size() + 1, rest.size()));
      const Ordered told = is_nested_deeply(line) ? Ordered(Ordered::value_t::discarded)
                                                  : Ordered::parse(line, nullptr, false);
      const bool is_problem = told.is_object() && told.contains("status");
      if (end == std::string_view::npos || told.is_discarded() || is_problem) {
        return Error{ErrorKind::kInvalid, "SERVER_REFUSES",
                     "the answer ends early: " + last_words(told, line), ""};
      }
      missed_ = is_miss(told);
      out_ << (command_.json ? std::string(line) + "\n" : answer_text(told));
    }
    return success();
  }
  /// Whether the last ray did.
  bool missed() const { return missed_; }

 private:
  const QueryCommand& command_;
  ApiClient& client_;
  std::ostream& out_;
  const std::string path_, options_;
  bool missed_ = false;
};

Status ask_all(Asker& asker, std::istream& in) {
  std::string lines, line;
  std::size_t rays = 0, number = 0;
  while (std::getline(in, line)) {
    auto ray = ray_line(line, ++number);
    if (!ray) return std::move(ray).error();
    if (ray->empty()) continue;
    lines += *ray;
    if (++rays < kRaysAtOnce) continue;
    if (Status status = asker.ask(lines, rays); !status) return status;
    lines.clear();
    rays = 0;
  }
  return rays > 0 ? asker.ask(lines, rays) : success();
}

}  // namespace

int run_query(const QueryCommand& command, std::istream& in, std::ostream& out,
              std::ostream& complaints) {
  const auto complain = [&](const Error& error) {
    complaints << "sightline: " << error.code << ": " << error.message << "\n";
    return kExitError;
  };
  const auto client = ApiClient::open(command.server);
  if (!client) return complain(client.error());
  Asker asker(command, **client, out);
  Status status = success();
  if (command.rays.empty()) {
    status = asker.ask(line_of(command.ray), 1);
  } else if (command.rays == "-") {
    status = ask_all(asker, in);
  } else {
    std::ifstream file(command.rays);
    if (!file) {
      return complain(
          {ErrorKind::kNotFound, "RAYS_UNREADABLE", "cannot read the file of --rays", ""});
    }
    status = ask_all(asker, file);
  }
  out.flush();
  if (!status) return complain(status.error());
  return command.rays.empty() && asker.missed() ? kExitMiss : kExitGood;
}

}  // namespace sightline
