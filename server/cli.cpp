#include "server/cli.h"

#include <CLI/CLI.hpp>

#include <charconv>
#include <limits>
#include <sstream>

#include "server/config_file.h"
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

/// All subcommands with their flags, and what one parse of them says.
class CommandLine {
 public:
  CommandLine() {
    app_.require_subcommand(1);
    app_.set_version_flag("--version", version_text());
    serve_app_ = app_.add_subcommand("serve", "answer queries over HTTP until a signal");
    define_serve(*serve_app_, serve_, serve_flags_);
    cast_app_ = app_.add_subcommand(
        "cast", "cast one ray into a file; exit code 0 for a hit, 1 for a miss, 2 for an error");
    define_cast(*cast_app_, cast_, cast_flags_);
    CLI::App* demo_app = app_.add_subcommand("demo", "write a demo scene as a .glb file");
    demo_app->add_option("NAME", demo_.name, "town or six")->required();
    demo_app->add_option("OUT", demo_.file, "the file to write")->required();
    check_app_ = app_.add_subcommand(
        "check-config", "say what is wrong with a file for serve --config; exit code 0 or 2");
    check_app_->add_option("FILE", check_.file, "the file")->required();
    CLI::App* key_app = app_.add_subcommand("key", "keys that clients show");
    key_app->require_subcommand(1);
    new_key_app_ = key_app->add_subcommand(
        "new", "print a fresh key, this once, and the line of the file of --keys that lets it in");
    new_key_app_->add_option("--role", role_, "'read': queries; 'write': scenes as well")
        ->check(CLI::IsMember({"read", "write"}))
        ->required();
    new_key_app_->add_option("--name", key_.name, "who has it, for the log")
        ->check(CLI::Validator(check_key_name, ""))
        ->required();
  }

  /// Throws CLI::ParseError.
  void parse(const std::vector<std::string>& arguments) {
    std::vector<const char*> texts;
    texts.reserve(arguments.size());
    for (const std::string& argument : arguments) texts.push_back(argument.c_str());
    app_.parse(static_cast<int>(texts.size()), texts.data());
  }
  /// After parse. Throws CLI::ParseError.
  Command command() {
    if (serve_app_->parsed()) {
      finish_serve(serve_, serve_flags_);
      serve_.flags = flag_texts(*serve_app_);
      return serve_;
    }
    if (cast_app_->parsed()) {
      finish_cast(cast_, cast_flags_);
      return cast_;
    }
    if (check_app_->parsed()) return check_;
    if (new_key_app_->parsed()) {
      key_.access = role_ == "write" ? Access::kWrite : Access::kRead;
      return key_;
    }
    return demo_;
  }
  /// What to tell whom it did not please.
  ShowText text_of(const CLI::ParseError& error) const {
    if (error.get_exit_code() == 0) {
      std::ostringstream out;
      app_.exit(error, out, out);
      return {out.str(), 0};
    }
    std::string asked = "sightline";
    for (const CLI::App* command : app_.get_subcommands()) {
      asked += " ";
      asked += command->get_name();
    }
    // 1 is taken: a ray that misses.
    return {"sightline: " + std::string(error.what()) + "\nSee " + asked + " --help\n", 2};
  }

  const std::string& config() const { return serve_.config; }
  /// Null where serve has no such flag, or it is none for a file.
  const CLI::Option* setting(const std::string& name) const {
    if (name == "help" || name == "config") return nullptr;
    return name.empty() ? nullptr : serve_app_->get_option_no_throw("--" + name);
  }

 private:
  CLI::App app_{"Exact ray queries against glTF scenes.", "sightline"};
  CLI::App *serve_app_, *cast_app_, *check_app_, *new_key_app_;
  ServeCommand serve_;
  ServeFlags serve_flags_;
  CastCommand cast_;
  CastFlags cast_flags_;
  DemoCommand demo_;
  CheckCommand check_;
  KeyCommand key_;
  std::string role_;
};

/// What is wrong with one setting by itself, or nothing.
std::string check_setting(const Setting& setting) {
  CommandLine line;
  if (line.setting(setting.name) == nullptr) return "there is no such setting";
  try {
    std::vector<std::string> arguments{"sightline", "serve"};
    append_flags(setting, arguments);
    line.parse(arguments);
    (void)line.command();
  } catch (const CLI::ParseError& error) {
    return error.what();
  }
  return "";
}

/// The settings of a file that are good; `mistakes` gets the others.
std::vector<Setting> good_settings(const std::string& file, std::vector<std::string>& mistakes) {
  std::vector<Setting> good;
  for (Setting& setting : read_config(file, mistakes)) {
    const std::string wrong = check_setting(setting);
    if (wrong.empty()) {
      good.push_back(std::move(setting));
    } else {
      mistakes.push_back(place_of(file, setting) + wrong);
    }
  }
  return good;
}

std::string lines_of(const std::vector<std::string>& mistakes) {
  std::string text;
  for (const std::string& mistake : mistakes) text += "sightline: " + mistake + "\n";
  return text;
}

}  // namespace

Command parse_command_line(const std::vector<std::string>& arguments) {
  CommandLine plain, whole;
  try {
    plain.parse(arguments);
    auto all = arguments;
    if (!plain.config().empty()) {
      std::vector<std::string> mistakes;
      for (const Setting& setting : good_settings(plain.config(), mistakes)) {
        if (plain.setting(setting.name)->count() == 0) append_flags(setting, all);
      }
      if (!mistakes.empty()) return ShowText{lines_of(mistakes), 2};
    }
    whole.parse(all);
    Command command = whole.command();
    if (auto* serve = std::get_if<ServeCommand>(&command)) {
      check_together(*serve);
      serve->arguments = arguments;
    }
    return command;
  } catch (const CLI::ParseError& error) {
    return plain.text_of(error);
  }
}

std::vector<std::string> mistakes_of_config(const std::string& file) {
  std::vector<std::string> mistakes, arguments{"sightline", "serve"};
  for (const Setting& setting : good_settings(file, mistakes)) append_flags(setting, arguments);
  if (!mistakes.empty()) return mistakes;
  try {
    CommandLine line;
    line.parse(arguments);
    const auto command = std::get<ServeCommand>(line.command());
    check_together(command);
    std::vector<std::string> warnings;
    if (command.keys.empty()) return mistakes;
    const auto ring = KeyRing::read(command.keys, warnings);
    if (!ring) mistakes.push_back(file + ": " + ring.error().message);
  } catch (const CLI::ParseError& error) {
    mistakes.push_back(file + ": " + error.what());
  }
  return mistakes;
}

}  // namespace sightline
