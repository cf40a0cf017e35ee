#include "server/operation/cli.h"

#include <CLI/CLI.hpp>

#include <sstream>

#include "core/base/watch.h"
#include "core/query/similar_names.h"
#include "server/http/spool.h"
#include "server/operation/config_file.h"
#include "server/operation/data_folder.h"
#include "server/operation/ray_flags.h"
#include "server/operation/serve_flags.h"
#include "server/operation/version.h"
#include "server/sources/scene_root.h"

namespace sightline {
namespace {

std::string check_key_name(const std::string& text) {
  return is_key_name(text) ? ""
                           : "a key's name has 1 to 128 of the characters A-Z a-z 0-9 . _ -, does "
                             "not begin with a dot, and is no key";
}

/// All subcommands with their flags, and what one parse of them says.
class CommandLine {
 public:
  CommandLine() {
    app_.require_subcommand(1);
    app_.set_version_flag("--version", version_text());
    serve_app_ = app_.add_subcommand("serve", "answer queries over HTTP until a signal");
    define_serve(*serve_app_, serve_, serve_flags_);
    cast_app_ = app_.add_subcommand("cast",
                                    "trace rays through a file; exit code 0, 1 if the only ray "
                                    "misses (not with --rays), 2 for an "
                                    "error");
    define_cast(*cast_app_, cast_, cast_flags_);
    query_app_ = app_.add_subcommand("query",
                                     "ask a server about rays; exit code 0, 1 if the only ray "
                                     "misses (not with --rays), 2 for an error");
    define_query(*query_app_, query_, query_flags_);
    mcp_app_ = app_.add_subcommand(
        "mcp",
        "let an agent ask a server: the Model Context Protocol on standard input and output");
    define_mcp(*mcp_app_, mcp_);
    CLI::App* demo_app = app_.add_subcommand("demo", "write a demo scene as a .glb file");
    demo_app->add_option("NAME", demo_.name, "town, six or painted")->required();
    demo_app->add_option("OUT", demo_.file, "the file to write")->required();
    convert_app_ = app_.add_subcommand(
        "convert", "write an OBJ, PLY, STL, DAE, FBX or 3MF file as .glb, in a process of its own");
    convert_app_->add_option("IN", convert_.from, "the file to read")->required();
    convert_app_->add_option("OUT", convert_.to, "the .glb file to write")->required();
    convert_app_
        ->add_option("--memory-mib", convert_.memory_mib,
                     "the most memory, and size of OUT, in MiB")
        ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 20))
        ->capture_default_str();
    convert_app_
        ->add_option("--seconds", convert_.seconds,
                     "the most seconds of processor time; twice as many in total")
        ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{86'400}))
        ->capture_default_str();
    check_app_ = app_.add_subcommand(
        "check-config", "check a file of settings for serve --config; exit code 0 or 2");
    check_app_->add_option("FILE", check_.file, "the file")->required();
    CLI::App* key_app = app_.add_subcommand("key", "keys of clients");
    key_app->require_subcommand(1);
    new_key_app_ = key_app->add_subcommand(
        "new", "print a new key, which is not stored, and its line for the file of --keys");
    new_key_app_->add_option("--role", role_, "'read': queries; 'write': also changes of scenes")
        ->check(CLI::IsMember({"read", "write"}))
        ->required();
    new_key_app_->add_option("--name", key_.name, "name of the client, for the log")
        ->check(CLI::Validator(check_key_name, ""))
        ->required()
        ->type_name("NAME");
  }

  /// For a server that runs: its file of keys is read separately.
  void leave_keys() { serve_app_->get_option("--keys")->get_validator()->active(false); }

  /// Throws CLI::ParseError. `help` and `help COMMAND` are --help.
  void parse(std::vector<std::string> arguments) {
    if (arguments.size() > 1 && arguments[1] == "help") {
      arguments.erase(arguments.begin() + 1);
      arguments.push_back("--help");
    }
    // The library would miss a command, and not say which word is none.
    if (arguments.size() > 1 && !arguments[1].starts_with('-') &&
        app_.get_subcommands([&](const CLI::App* app) { return app->get_name() == arguments[1]; })
            .empty()) {
      throw CLI::ValidationError("there is no command '" + arguments[1] + "'" +
                                 similar_commands(arguments[1]));
    }
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
    if (convert_app_->parsed()) return convert_;
    if (check_app_->parsed()) return check_;
    if (new_key_app_->parsed()) {
      key_.access = role_ == "write" ? Access::kWrite : Access::kRead;
      return key_;
    }
    return demo_;
  }
  /// What to print for an error.
  ShowText text_of(const CLI::ParseError& error) const {
    if (error.get_exit_code() == 0) {
      std::ostringstream out;
      app_.exit(error, out, out);
      return {out.str(), 0};
    }
    std::string asked = "sightline";
    const CLI::App* last = &app_;
    for (auto commands = app_.get_subcommands(); !commands.empty();) {
      last = commands.front();
      asked += " " + last->get_name();
      commands = last->get_subcommands();
    }
    // 1 is taken: a ray that misses.
    return {"sightline: " + std::string(error.what()) + similar_flags(*last) + "\nSee " + asked +
                " --help\n",
            2};
  }

  const std::string& config() const { return serve_.config; }
  /// Null where serve has no such flag, or it is none for a file.
  const CLI::Option* setting(const std::string& name) const {
    if (name == "help" || name == "config") return nullptr;
    return name.empty() ? nullptr : serve_app_->get_option_no_throw("--" + name);
  }

 private:
  std::string similar_commands(const std::string& word) const {
    const auto commands = app_.get_subcommands([](const CLI::App*) { return true; });
    std::vector<std::string> known;
    known.reserve(commands.size());
    for (const CLI::App* command : commands) known.push_back(command->get_name());
    return similar_text(word, known);
  }
  /// The flags of a command that are similar to the first one that it does not know.
  std::string similar_flags(const CLI::App& command) const {
    std::vector<std::string> known;
    for (const CLI::Option* option : command.get_options()) {
      for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    }
    for (const std::string& word : app_.remaining(true)) {
      if (word.starts_with("--")) return similar_text(word.substr(0, word.find('=')), known);
    }
    return {};
  }
  static std::string similar_text(const std::string& word, const std::vector<std::string>& known) {
    const Deadline never = Deadline::never();
    DeadlineWatch watch(never);
    return similar_names_text(
        word, known.size(), [&](std::size_t i) { return std::string_view(known[i]); }, 1 << 16,
        watch);
  }

  CLI::App app_{"Exact ray queries against glTF scenes.", "sightline"};
  CLI::App *serve_app_, *cast_app_, *query_app_, *mcp_app_, *convert_app_, *check_app_,
      *new_key_app_;
  ServeCommand serve_;
  ServeFlags serve_flags_;
  CastCommand cast_;
  CastFlags cast_flags_;
  QueryCommand query_;
  QueryFlags query_flags_;
  McpCommand mcp_;
  DemoCommand demo_;
  ConvertCommand convert_;
  CheckCommand check_;
  KeyCommand key_;
  std::string role_;
};

/// Whether the file of keys is checked with the settings.
enum class KeysFile { kWithSettings, kByItself };

/// What is wrong with one setting by itself, or nothing.
std::string check_setting(const Setting& setting, KeysFile keys) {
  CommandLine line;
  if (keys == KeysFile::kByItself) line.leave_keys();
  const CLI::Option* option = line.setting(setting.name);
  if (option == nullptr) return "there is no such setting";
  const bool is_switch = option->get_items_expected_max() == 0;
  if (is_switch && setting.values != std::vector<std::string>{"true"} &&
      setting.values != std::vector<std::string>{"false"}) {
    return "it is true or false";
  }
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
std::vector<Setting> good_settings(const std::string& file, std::vector<std::string>& mistakes,
                                   KeysFile keys = KeysFile::kWithSettings) {
  std::vector<Setting> good;
  for (Setting& setting : read_config(file, mistakes)) {
    const std::string wrong = check_setting(setting, keys);
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

/// What the library or check_together says of a flag, "--name: text", at the place in the file
/// where that flag stands.
std::string placed(const std::string& file, const std::vector<Setting>& settings,
                   const std::string& what) {
  const std::size_t colon = what.find(": ");
  for (const Setting& setting : settings) {
    if (what.starts_with("--") && colon == setting.name.size() + 2 &&
        what.compare(2, setting.name.size(), setting.name) == 0) {
      return place_of(file, setting) + what.substr(colon + 2);
    }
  }
  return file + ": " + what;
}

Command parse(const std::vector<std::string>& arguments, KeysFile keys) {
  CommandLine plain, whole;
  if (keys == KeysFile::kByItself) {
    plain.leave_keys();
    whole.leave_keys();
  }
  try {
    plain.parse(arguments);
    auto all = arguments;
    if (!plain.config().empty()) {
      std::vector<std::string> mistakes;
      for (const Setting& setting : good_settings(plain.config(), mistakes, keys)) {
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

}  // namespace

Command parse_command_line(const std::vector<std::string>& arguments) {
  return parse(arguments, KeysFile::kWithSettings);
}

Command parse_again(const std::vector<std::string>& arguments) {
  return parse(arguments, KeysFile::kByItself);
}

ConfigReport report_of_config(const std::string& file) {
  ConfigReport report;
  std::vector<std::string> arguments{"sightline", "serve"};
  const auto settings = good_settings(file, report.mistakes);
  for (const Setting& setting : settings) append_flags(setting, arguments);
  if (!report.mistakes.empty()) return report;
  const auto mistake = [&](const std::string& what) {
    report.mistakes.push_back(placed(file, settings, what));
  };
  try {
    CommandLine line;
    line.parse(arguments);
    const auto command = std::get<ServeCommand>(line.command());
    check_together(command);
    for (const std::string& text : warnings_of(command)) {
      report.warnings.push_back(placed(file, settings, text));
    }
    if (!command.keys.empty()) {
      std::vector<std::string> warnings;
      const auto ring = KeyRing::read(command.keys, warnings);
      if (!ring) mistake("--keys: " + ring.error().message);
      for (const std::string& text : warnings) {
        report.warnings.push_back(placed(file, settings, "--keys: " + text));
      }
    }
    if (!command.data.empty()) {
      if (const Status good = check_data_folder(command.data); !good) {
        mistake("--data: " + good.error().message);
      }
    }
    if (const Status good = SpoolFile::can_be_made_in(command.http.spool_folder); !good) {
      mistake("--spool-dir: " + good.error().message);
    }
    if (!command.scene_root.empty()) {
      if (const auto root = SceneRoot::open(command.scene_root); !root) {
        mistake("--scene-root: " + root.error().message);
      }
    }
  } catch (const CLI::ParseError& error) {
    mistake(error.what());
  }
  return report;
}

}  // namespace sightline
