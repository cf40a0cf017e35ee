#include "server/cli.h"

#include <CLI/CLI.hpp>

#include <charconv>
#include <limits>
#include <sstream>

#include "server/serve_flags.h"
#include "server/version.h"

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

FieldSet parse_fields(const std::string& text) {
  FieldSet fields;
  std::stringstream names(text);
  std::string name, known;
  for (const HitField field : all_hit_fields()) {
    if (!known.empty()) known += ",";
    known += hit_field_name(field);
  }
  while (std::getline(names, name, ',')) {
    const auto field = find_hit_field(name);
    if (!field) {
      std::string refusal = "'" + name + "' is not a field of a hit; there are ";
      refusal += known;
      throw CLI::ValidationError("--fields", refusal);
    }
    fields.add(*field);
  }
  return fields;
}

std::string check_scene_number(const std::string& text) {
  std::uint32_t value = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value);
  const bool good = error == std::errc() && last == end;
  return good ? "" : "'" + text + "' is not the number of a scene: 0, 1, 2, ...";
}

struct CastFlags {
  std::string origin, direction, tmin, tmax, fields, crossings = "every";
  bool any = false, all = false, count = false;
};

std::string check_key_name(const std::string& text) {
  return is_key_name(text) ? "" : "a key's name has 1 to 128 of the characters A-Z a-z 0-9 . _ -";
}

void define_cast(CLI::App& app, CastCommand& command, CastFlags& flags) {
  app.add_option("FILE", command.source, "a .glb or .gltf file, or demo:town, demo:six")
      ->required();
  app.add_option("--origin", flags.origin, "where the ray starts")->required()->type_name("X,Y,Z");
  app.add_option("--direction", flags.direction, "need not be of unit length")
      ->required()
      ->type_name("X,Y,Z");
  app.add_option("--tmin", flags.tmin, "least t, counted in |direction| (default 0)")
      ->type_name("T");
  app.add_option("--tmax", flags.tmax, "largest t (default: no limit)")->type_name("T");
  app.add_option("--scene", command.scene, "which scene of the file (default: the file's choice)")
      ->check(CLI::Validator(check_scene_number, ""))
      ->type_name("N");
  app.add_option("--fields", flags.fields, "what to print of the hit, comma-separated");
  app.add_option("--kernel", command.kernel, "traversal kernel (see --version); default: the best");
  CLI::App* modes = app.add_option_group("mode", "what to print; default: the closest hit");
  CLI::Option* any =
      modes->add_flag("--any", flags.any, "only whether there is a hit: true or false");
  CLI::Option* all =
      modes->add_flag("--all", flags.all, "every hit, one line each, in the order of t");
  CLI::Option* count = modes->add_flag("--count", flags.count, "only how many hits there are");
  all->excludes(any);
  count->excludes(any, all);
  app.add_option("--crossings", flags.crossings,
                 "what --all and --count take for a hit: 'every' triangle that is met, or each "
                 "passage through a surface 'once', though it be at an edge or a corner")
      ->check(CLI::IsMember({"every", "once"}))
      ->capture_default_str();
}

void finish_cast(CastCommand& command, const CastFlags& flags) {
  command.ray.origin = parse_vector(flags.origin, "--origin");
  command.ray.direction = parse_vector(flags.direction, "--direction");
  if (!flags.tmin.empty()) command.ray.tmin = parse_number(flags.tmin, "--tmin");
  if (!flags.tmax.empty()) command.ray.tmax = parse_number(flags.tmax, "--tmax");
  if (!flags.fields.empty()) command.fields = parse_fields(flags.fields);
  command.mode = flags.any     ? CastMode::kAny
                 : flags.all   ? CastMode::kAll
                 : flags.count ? CastMode::kCount
                               : CastMode::kClosest;
  if (flags.crossings == "once") {
    if (!flags.all && !flags.count) {
      throw CLI::ValidationError("--crossings", "once belongs to --all or --count");
    }
    command.crossings = Crossings::kOnce;
  }
}

}  // namespace

Command parse_command_line(int argc, const char* const* argv) {
  CLI::App app("Exact ray queries against glTF scenes.", "sightline");
  app.require_subcommand(1);
  app.set_version_flag("--version", version_text());

  ServeCommand serve;
  ServeFlags serve_flags;
  CLI::App* serve_app = app.add_subcommand("serve", "answer queries over HTTP until a signal");
  define_serve(*serve_app, serve, serve_flags);

  CastCommand cast;
  CastFlags cast_flags;
  CLI::App* cast_app = app.add_subcommand(
      "cast", "cast one ray into a file; exit code 0 for a hit, 1 for a miss, 2 for an error");
  define_cast(*cast_app, cast, cast_flags);

  DemoCommand demo;
  CLI::App* demo_app = app.add_subcommand("demo", "write a demo scene as a .glb file");
  demo_app->add_option("NAME", demo.name, "town or six")->required();
  demo_app->add_option("OUT", demo.file, "the file to write")->required();

  KeyCommand key;
  std::string role;
  CLI::App* key_app = app.add_subcommand("key", "keys that clients show")->require_subcommand(1);
  CLI::App* new_app = key_app->add_subcommand(
      "new", "print a fresh key, this once, and the line of the file of --keys that lets it in");
  new_app->add_option("--role", role, "'read': queries; 'write': scenes as well")
      ->check(CLI::IsMember({"read", "write"}))
      ->required();
  new_app->add_option("--name", key.name, "who has it, for the log")
      ->check(CLI::Validator(check_key_name, ""))
      ->required();

  try {
    app.parse(argc, argv);
    if (serve_app->parsed()) {
      finish_serve(serve, serve_flags);
      return serve;
    }
    if (cast_app->parsed()) {
      finish_cast(cast, cast_flags);
      return cast;
    }
    if (new_app->parsed()) {
      key.access = role == "write" ? Access::kWrite : Access::kRead;
      return key;
    }
    return demo;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      std::ostringstream out;
      app.exit(error, out, out);
      return ShowText{out.str(), 0};
    }
    std::string asked = "sightline";
    for (const CLI::App* command : app.get_subcommands()) {
      asked += " ";
      asked += command->get_name();
    }
    // 1 is taken: a ray that misses.
    return ShowText{"sightline: " + std::string(error.what()) + "\nSee " + asked + " --help\n", 2};
  }
}

}  // namespace sightline
