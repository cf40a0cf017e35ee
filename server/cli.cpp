#include "server/cli.h"

#include <CLI/CLI.hpp>

#include <charconv>
#include <limits>
#include <sstream>

#include "core/store/scene_id.h"
#include "server/door_flags.h"
#include "server/flag_checks.h"
#include "server/scene_source.h"
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

std::pair<std::string, std::string> parse_preload(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) throw CLI::ValidationError("--preload", "needs ID=FILE");
  std::pair<std::string, std::string> preload{text.substr(0, equals), text.substr(equals + 1)};
  if (!is_scene_id(preload.first)) {
    throw CLI::ValidationError("--preload", scene_id_invalid().message);
  }
  if (const Status found = check_source(preload.second); !found) {
    throw CLI::ValidationError("--preload", found.error().message);
  }
  return preload;
}

/// Flags as they are written, and what becomes of them after the parse.
struct ServeFlags {
  std::string listen = "127.0.0.1:8080";
  std::string skip = "all";
  std::vector<std::string> preloads, allow_urls, allow_addresses;
  double fetch_seconds = 300;
  double drain_seconds = 30, notice_seconds = 0, request_seconds = 60;
  DoorSeconds door;
};

std::string check_scene_number(const std::string& text) {
  std::uint32_t value = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value);
  const bool good = error == std::errc() && last == end;
  return good ? "" : "'" + text + "' is not the number of a scene: 0, 1, 2, ...";
}

void define_serve(CLI::App& app, ServeCommand& command, ServeFlags& flags) {
  app.add_option("--listen", flags.listen, "ADDR:PORT; port 0 takes a free one")
      ->capture_default_str();
  app.add_option("--data", command.data,
                 "folder where scenes are kept; without it they live in memory only");
  app.add_option("--preload", flags.preloads,
                 "ID=FILE or ID=demo:town, ID=demo:six: a scene to load at the start (repeatable)")
      ->take_all();
  app.add_option("--threads", command.threads, "threads that trace; 0: as many as the machine has")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  app.add_option("--kernel", command.kernel, "traversal kernel (see --version); default: the best");
  app.add_option("--log-level", command.log_level, "of the log on standard error")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  const CLI::Validator count([](std::string& text) { return check_positive_count(text); },
                             "POSITIVE");
  app.add_option("--max-scene-bytes", command.limits.scene_bytes, "of an uploaded scene")
      ->check(count)
      ->capture_default_str();
  app.add_option("--max-query-bytes", command.limits.query_bytes, "of a query's body")
      ->check(count)
      ->capture_default_str();
  app.add_option("--max-rays", command.limits.rays, "in one request")
      ->check(count)
      ->capture_default_str();
  app.add_option("--max-hits", command.limits.hits, "listed in one answer to rays:all")
      ->check(count)
      ->capture_default_str();
  app.add_option("--max-loads", command.limits.loads,
                 "scenes that may be on their way at once; two of them are built at a time")
      ->check(count)
      ->capture_default_str();
  app.add_option("--skip", flags.skip,
                 "'all': trees are built when rays come near, or ahead of them; 'none': before a "
                 "scene is ready. No answer depends on it")
      ->check(CLI::IsMember({"all", "none"}))
      ->capture_default_str();
  app.add_option("--memory-budget", command.memory_budget,
                 "bytes of all scenes with their trees; the trees that were asked the longest ago "
                 "go first (default: no limit)")
      ->check(count);
  app.add_option("--scene-root", command.scene_root,
                 "folder below which clients may name files to load (POST /v1/scenes with a path)")
      ->check(CLI::ExistingDirectory);
  app.add_option(
         "--allow-url", flags.allow_urls,
         "URLs that clients may name: SCHEME://HOST[:PORT][/PATH] with *.example.org, * and "
         ":* as wildcards; a PATH that ends with / allows all below (repeatable)")
      ->take_all()
      ->type_name("PATTERN");
  app.add_option("--allow-address", flags.allow_addresses,
                 "addresses like 10.0.0.0/8 that those URLs may lead to; without it only public "
                 "ones (repeatable)")
      ->take_all()
      ->type_name("RANGE");
  // Below a millisecond a request or a connection would have no time at all.
  const CLI::Validator span([](std::string& text) { return check_seconds(text, 0.001); },
                            "SECONDS");
  const CLI::Validator wait([](std::string& text) { return check_seconds(text, 0); }, "SECONDS");
  app.add_option("--request-seconds", flags.request_seconds, "how long one request may trace")
      ->check(span)
      ->capture_default_str();
  app.add_option("--fetch-seconds", flags.fetch_seconds,
                 "how long it may take to fetch a URL, with all redirects")
      ->check(span)
      ->capture_default_str();
  app.add_option("--drain-seconds", flags.drain_seconds,
                 "how long a stop waits for requests that have begun")
      ->check(wait)
      ->capture_default_str();
  app.add_option("--notice-seconds", flags.notice_seconds,
                 "how long /readyz says 503 before a stop, for load balancers")
      ->check(wait)
      ->capture_default_str();
  define_door(app, command.door, flags.door);
}

template <class Parsed>
std::vector<Parsed> parse_each(const std::vector<std::string>& texts, const char* flag) {
  std::vector<Parsed> list;
  for (const std::string& text : texts) {
    auto parsed = Parsed::parse(text);
    if (!parsed) throw CLI::ValidationError(flag, parsed.error().message);
    list.push_back(std::move(*parsed));
  }
  return list;
}

void finish_serve(ServeCommand& command, const ServeFlags& flags) {
  auto listen = parse_listen_address(flags.listen);
  if (!listen) throw CLI::ValidationError("--listen", listen.error().message);
  command.listen = std::move(*listen);
  for (const std::string& preload : flags.preloads) {
    command.preloads.push_back(parse_preload(preload));
  }
  command.urls.patterns = parse_each<UrlPattern>(flags.allow_urls, "--allow-url");
  command.urls.addresses = parse_each<AddressRange>(flags.allow_addresses, "--allow-address");
  command.urls.time = milliseconds_of(flags.fetch_seconds);
  // Each of these holds a worker: half of all may wait, a quarter more may listen.
  command.limits.waiters = command.door.workers / 2;
  command.limits.listeners = command.door.workers / 4;
  command.laziness = flags.skip == "none" ? Laziness::kEager : Laziness::kWhenNeeded;
  command.limits.request = milliseconds_of(flags.request_seconds);
  finish_door(command.door, flags.door);
  command.drain = milliseconds_of(flags.drain_seconds);
  command.notice = milliseconds_of(flags.notice_seconds);
}

struct CastFlags {
  std::string origin, direction, tmin, tmax, fields, crossings = "every";
  bool any = false, all = false, count = false;
};

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
