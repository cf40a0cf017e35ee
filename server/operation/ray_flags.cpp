#include "server/operation/ray_flags.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>

#include "core/query/attribute_name.h"
#include "server/operation/flag_checks.h"

namespace sightline {
namespace {

/// The nearest float64, rounded once: the library's own conversion goes through long double.
double parse_number(const std::string& text, const char* flag) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value);
  if (error == std::errc::result_out_of_range && last == end) {
    throw CLI::ValidationError(flag, "'" + text + "' is beyond a float64");
  }
  if (text.empty() || error != std::errc() || last != end) {
    throw CLI::ValidationError(flag, "'" + text + "' is not a number");
  }
  return value;
}

Vec3d parse_vector(const std::string& text, const char* flag) {
  Vec3d vector;
  std::stringstream parts(text);
  std::string part;
  int count = 0;
  while (std::getline(parts, part, ',')) {
    if (count < 3) vector[count] = parse_number(part, flag);
    ++count;
  }
  if (count != 3 || text.ends_with(',')) {
    throw CLI::ValidationError(flag, "needs three numbers, x,y,z");
  }
  return vector;
}

void parse_fields(const std::string& text, RayQuestion& question) {
  FieldSet& fields = question.fields.emplace();
  std::stringstream names(text);
  std::string name, known;
  for (const HitField field : all_hit_fields()) {
    if (!known.empty()) known += ",";
    known += hit_field_name(field);
  }
  while (std::getline(names, name, ',')) {
    const bool is_named = is_attribute_name(name);
    const auto field = is_named ? HitField::kNamed : find_hit_field(name);
    if (!field) {
      std::string refusal = "'" + name + "' is not a field of a hit; there are ";
      refusal += known;
      throw CLI::ValidationError("--fields", refusal);
    }
    fields.add(*field);
    auto& named = question.named_fields;
    if (is_named && std::find(named.begin(), named.end(), name) == named.end())
      named.push_back(name);
  }
}

std::string check_scene_number(const std::string& text) {
  std::uint32_t value = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value);
  const bool good = error == std::errc() && last == end;
  return good ? "" : "'" + text + "' is not the number of a scene: 0, 1, 2, ...";
}

void define_ray(CLI::App& app, RayFlags& flags) {
  app.add_option("--origin", flags.origin, "origin of the ray")->type_name("X,Y,Z");
  app.add_option("--direction", flags.direction, "direction of the ray, of any length")
      ->type_name("X,Y,Z");
  app.add_option("--tmin", flags.tmin, "least t, in units of |direction| (default 0)")
      ->type_name("T");
  app.add_option("--tmax", flags.tmax, "largest t (default: no limit)")->type_name("T");
}

Ray finish_ray(const RayFlags& flags) {
  Ray ray;
  ray.origin = parse_vector(flags.origin, "--origin");
  ray.direction = parse_vector(flags.direction, "--direction");
  if (!flags.tmin.empty()) ray.tmin = parse_number(flags.tmin, "--tmin");
  if (!flags.tmax.empty()) ray.tmax = parse_number(flags.tmax, "--tmax");
  return ray;
}

void define_mode(CLI::App& app, ModeFlags& flags) {
  CLI::App* modes = app.add_option_group("mode", "what to print; default: the closest hit");
  CLI::Option* any =
      modes->add_flag("--any", flags.any, "only whether there is a hit: true or false");
  CLI::Option* all = modes->add_flag("--all", flags.all, "every hit, sorted by t");
  CLI::Option* count = modes->add_flag("--count", flags.count, "only how many hits there are");
  all->excludes(any);
  count->excludes(any, all);
  app.add_option("--crossings", flags.crossings,
                 "what --all and --count count as hits: 'every' triangle that is met, or each "
                 "passage through a surface 'once', even at an edge or a corner")
      ->check(CLI::IsMember({"every", "once"}))
      ->capture_default_str();
}

void finish_mode(const ModeFlags& flags, CastMode& mode, Crossings& crossings) {
  mode = flags.any     ? CastMode::kAny
         : flags.all   ? CastMode::kAll
         : flags.count ? CastMode::kCount
                       : CastMode::kClosest;
  if (flags.crossings != "once") return;
  if (!flags.all && !flags.count) {
    throw CLI::ValidationError("--crossings", "once belongs to --all or --count");
  }
  crossings = Crossings::kOnce;
}

constexpr std::array<const char*, 3> kFormats{"text", "json", "hits"};

/// The flags that cast and query have in common. `command` has the default format.
void define_question(CLI::App& app, RayQuestion& command, CastFlags& flags) {
  define_ray(app, flags.ray);
  app.add_option("--rays", command.rays,
                 "instead of one ray, a file of rays, - for standard input: in each line six "
                 "numbers, origin and direction, then tmin and tmax if there are limits; or a ray "
                 "as JSON")
      ->excludes("--origin", "--direction", "--tmin", "--tmax")
      ->type_name("FILE");
  app.add_option("--fields", flags.fields, "what to print of a hit, comma-separated")
      ->type_name("NAMES");
  define_mode(app, flags.mode);
  flags.format = kFormats[static_cast<std::size_t>(command.format)];
  CLI::Option* format = app.add_option("--format", flags.format,
                                       "text for people, json with a line for each ray, or hits: "
                                       "json with a line for each hit");
  format->check(CLI::IsMember({kFormats[0], kFormats[1], kFormats[2]}))->capture_default_str();
  app.add_flag("--json", flags.json, "the same as --format json")->excludes(format);
}

void finish_question(const char* name, RayQuestion& command, const CastFlags& flags) {
  if (command.rays.empty()) {
    if (flags.ray.origin.empty() || flags.ray.direction.empty()) {
      throw CLI::ValidationError(
          name, "needs --origin and --direction, or --rays: one of both is required");
    }
    command.ray = finish_ray(flags.ray);
  }
  if (!flags.fields.empty()) parse_fields(flags.fields, command);
  finish_mode(flags.mode, command.mode, command.crossings);
  const auto* const format =
      std::find(kFormats.begin(), kFormats.end(), flags.json ? "json" : flags.format);
  command.format = static_cast<PrintFormat>(format - kFormats.begin());
}

void define_server(CLI::App& app, ServerAddress& server) {
  app.add_option("--key-file", server.key_file,
                 "file with the key of this client; default: $SIGHTLINE_KEY, if it is set")
      ->type_name("FILE");
}

}  // namespace

void define_cast(CLI::App& app, CastCommand& command, CastFlags& flags) {
  app.add_option("FILE", command.source,
                 "a .glb or .gltf file, or demo:town, demo:six, demo:painted")
      ->required();
  command.format = PrintFormat::kHits;
  define_question(app, command, flags);
  app.add_option("--scene", command.scene,
                 "index of the scene in the file (default: the file's default scene)")
      ->check(CLI::Validator(check_scene_number, ""))
      ->type_name("N");
  app.add_option("--kernel", command.kernel, "traversal kernel (see --version); default: the best")
      ->type_name("NAME");
}

void finish_cast(CastCommand& command, const CastFlags& flags) {
  finish_question("cast", command, flags);
}

void define_query(CLI::App& app, QueryCommand& command, QueryFlags& flags) {
  app.add_option("URL", command.server.url, "address of the server: http://127.0.0.1:8080")
      ->required();
  app.add_option("SCENE", command.scene, "name of the scene")->required();
  define_question(app, command, flags);
  define_server(app, command.server);
}

void finish_query(QueryCommand& command, const QueryFlags& flags) {
  finish_question("query", command, flags);
}

void define_mcp(CLI::App& app, McpCommand& command) {
  app.add_option("--url", command.server.url, "address of the server")
      ->default_val("http://127.0.0.1:8080")
      ->type_name("URL");
  app.add_option("--files", command.files,
                 "folder of files that the agent may upload (default: none)")
      ->check(CLI::ExistingDirectory);
  app.add_option("--max-answer-bytes", command.max_answer_bytes,
                 "longest answer in bytes; a longer one becomes a summary and pages")
      ->check(CLI::Range(4096, 1 << 28))
      ->capture_default_str();
  define_server(app, command.server);
}

}  // namespace sightline
