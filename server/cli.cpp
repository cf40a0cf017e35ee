#include "server/cli.h"

#include <CLI/CLI.hpp>

#include <sstream>

#include "server/config_file.h"
#include "server/ray_flags.h"
#include "server/serve_flags.h"
#include "server/version.h"

namespace sightline {
namespace {

std::string check_key_name(const std::string& text) {
  return is_key_name(text) ? "" : "a key's name has 1 to 128 of the characters A-Z a-z 0-9 . _ -";
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
    query_app_ = app_.add_subcommand(
        "query", "ask a server about rays; exit code 0, 1 where one ray misses, 2 for an error");
    define_query(*query_app_, query_, query_flags_);
    mcp_app_ = app_.add_subcommand(
        "mcp",
        "let an agent ask a server: the Model Context Protocol on standard input and output");
    define_mcp(*mcp_app_, mcp_);
    CLI::App* demo_app = app_.add_subcommand("demo", "write a demo scene as a .glb file");
    demo_app->add_option("NAME", demo_.name, "town, six or painted")->required();
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
    if (query_app_->parsed()) {
      finish_query(query_, query_flags_);
      return query_;
    }
    if (mcp_app_->parsed()) return mcp_;
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
  CLI::App *serve_app_, *cast_app_, *query_app_, *mcp_app_, *check_app_, *new_key_app_;
  ServeCommand serve_;
  ServeFlags serve_flags_;
  CastCommand cast_;
  CastFlags cast_flags_;
  QueryCommand query_;
  QueryFlags query_flags_;
  McpCommand mcp_;
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
