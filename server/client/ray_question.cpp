#include "server/client/ray_question.h"

#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "proto/json/json_parts.h"
#include "server/client/api_client.h"
#include "server/client/json_depth.h"

namespace sightline {
namespace {

using Ordered = nlohmann::ordered_json;

constexpr int kExitGood = 0, kExitMiss = 1, kExitError = 2;
/// Rays of one request: this bounds the memory of a file of any length.
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

std::string options_line(const RayQuestion& question) {
  Ordered options = Ordered::object();
  if (question.fields) {
    for (const HitField field : all_hit_fields()) {
      if (question.fields->has(field) && field != HitField::kNamed)
        options["fields"].push_back(hit_field_name(field));
    }
    for (const std::string& name : question.named_fields) options["fields"].push_back(name);
  }
  const bool lists = question.mode == CastMode::kAll || question.mode == CastMode::kCount;
  if (lists && question.crossings == Crossings::kOnce) options["crossings"] = "once";
  return Ordered{{"options", options}}.dump() + "\n";
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

/// Calls print(text) for each hit of a line {"total":2,"hits":[{...},{...}]}, or for another line.
/// The texts are cut out as they stand, so that numbers have all their digits.
template <class Print>
void print_hits(std::string_view line, const Print& print) {
  constexpr std::string_view kHits = "\"hits\":[";
  const std::size_t list =
      line.starts_with("{\"total\":") ? line.find(kHits) : std::string_view::npos;
  if (list == std::string_view::npos) return print(line);
  std::size_t depth = 0, begin = 0;
  bool is_text = false;
  for (std::size_t i = list + kHits.size(); i < line.size(); ++i) {
    const char c = line[i];
    if (is_text && c == '\\') ++i;
    if (c == '"') is_text = !is_text;
    if (is_text) continue;
    if (c == '{' && depth++ == 0) begin = i;
    if (c == '}' && depth > 0 && --depth == 0) print(line.substr(begin, i + 1 - begin));
  }
}

/// Asks for rays and prints what comes back.
class Asker {
 public:
  Asker(const RayQuestion& question, const AnswerLines& answer, std::ostream& out)
      : question_(question), answer_(answer), out_(out), options_(options_line(question)) {}

  /// Precondition: `lines` are `count` rays.
  Status ask(const std::string& lines, std::size_t count) {
    const auto answer = answer_(options_ + lines, count);
    if (!answer) return answer.error();
    std::string_view rest = *answer;
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
      print(told, line);
    }
    return success();
  }
  /// Whether the last ray did.
  bool missed() const { return missed_; }

 private:
  void print(const Ordered& told, std::string_view line) {
    if (question_.format == PrintFormat::kText) {
      out_ << answer_text(told);
    } else if (question_.format == PrintFormat::kJson) {
      out_ << line << "\n";
    } else {
      print_hits(line, [&](std::string_view hit) { out_ << hit << "\n"; });
    }
  }

  const RayQuestion& question_;
  const AnswerLines& answer_;
  std::ostream& out_;
  const std::string options_;
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

std::string_view question_kind(CastMode mode) {
  constexpr std::string_view kKinds[] = {"closest", "any", "all", "count"};
  return kKinds[static_cast<std::size_t>(mode)];
}

int complain(std::ostream& complaints, const Error& error) {
  complaints << "sightline: " << error.code << ": " << error.message << "\n";
  return kExitError;
}

int ask_rays(const RayQuestion& question, const AnswerLines& answer, std::istream& in,
             std::ostream& out, std::ostream& complaints) {
  Asker asker(question, answer, out);
  Status status = success();
  if (question.rays.empty()) {
    status = asker.ask(line_of(question.ray), 1);
  } else if (question.rays == "-") {
    status = ask_all(asker, in);
  } else {
    std::ifstream file(question.rays);
    if (!file) {
      return complain(complaints, {ErrorKind::kNotFound, "RAYS_UNREADABLE",
                                   "cannot read the file of --rays", ""});
    }
    status = ask_all(asker, file);
  }
  out.flush();
  if (!status) return complain(complaints, status.error());
  return question.rays.empty() && asker.missed() ? kExitMiss : kExitGood;
}

}  // namespace sightline
