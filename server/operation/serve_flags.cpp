#include "server/operation/serve_flags.h"

#include <algorithm>

#include "core/run/engine.h"
#include "core/store/scene_id.h"
#include "server/http/answer_headers.h"
#include "server/http/ip_address.h"
#include "server/operation/flag_maker.h"
#include "server/operation/system_limits.h"
#include "server/operation/version.h"
#include "server/service/scene_source.h"

namespace sightline {
namespace {

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

/// What the engine would say, but with the flag's name and place.
std::string check_kernel(const std::string& text) {
  std::string names;
  for (const std::string& name : Engine::kernels()) {
    if (name == text) return "";
    names += " " + name;
  }
  return "'" + text + "' is no kernel of this machine, which has" + names;
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

}  // namespace

void define_serve(CLI::App& app, ServeCommand& command, ServeFlags& flags) {
  app.add_option("--listen", flags.listen,
                 "address and port; for port 0 the system chooses a free port")
      ->capture_default_str()
      ->type_name("ADDR:PORT");
  app.add_option("--config", command.config,
                 "JSON file of settings: {\"max-rays\": 1000} is --max-rays 1000, a list repeats a "
                 "flag; flags of the command line take precedence")
      ->check(CLI::ExistingFile);
  app.add_option("--keys", command.keys,
                 "file with a line for each key of a client: 'sightline key new' makes them; "
                 "without it every client may do everything")
      ->check(CLI::ExistingFile);
  app.add_flag("--insecure", command.insecure,
               "listen without --keys even if other machines can connect");
  app.add_option("--cors-origin", command.cors_origins,
                 "pages of this origin may send requests: https://example.org, or * for all "
                 "(repeatable; default: none)")
      ->take_all()
      ->check(CLI::Validator(
          [](std::string& text) {
            return is_origin(text) ? "" : "'" + text + "' is no origin like https://example.org";
          },
          ""))
      ->type_name("ORIGIN");
  app.add_option("--data", command.data,
                 "folder in which scenes are stored; without it they are in memory only")
      ->check(CLI::Validator(
          [](std::string& text) { return text.empty() ? "the name of a folder is not empty" : ""; },
          ""))
      ->type_name("FOLDER");
  app.add_option(
         "--origin", command.origin,
         "folder, or s3://BUCKET/PREFIX, in which several servers share their scenes; --data "
         "is then a cache of it")
      ->type_name("ORIGIN");
  app.add_option("--origin-credentials", command.origin_credentials,
                 "file as ~/.aws/credentials: aws_access_key_id, aws_secret_access_key, region, "
                 "endpoint_url; default: the variables AWS_ACCESS_KEY_ID and so on")
      ->check(CLI::ExistingFile);
  app.add_option("--preload", flags.preloads,
                 "a scene to load at start, from a file or demo:town, demo:six, demo:painted "
                 "(repeatable)")
      ->take_all()
      ->type_name("ID=FILE");
  app.add_option("--threads", command.threads, "threads that trace rays; 0: one for each processor")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  app.add_option("--kernel", command.kernel, "traversal kernel (see --version); default: the best")
      ->check(CLI::Validator(check_kernel, ""))
      ->type_name("NAME");
  app.add_option("--log-level", command.log_level,
                 "least level of messages in the log on standard error")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "off"}))
      ->capture_default_str()
      ->group(kLiveFlags);
  app.add_option("--log-format", flags.log_format,
                 "'text' for people, or 'json' for programs: an object in each line")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  FlagMaker maker(app);
  maker.add_count("--max-scene-bytes", command.limits.scene_bytes, "size of an uploaded scene");
  maker.add_count("--max-query-bytes", command.limits.query_bytes, "size of the body of a query");
  maker.add_count("--max-rays", command.limits.rays,
                  "rays in one request; also points, boxes and pairs");
  maker.add_count("--max-hits", command.limits.hits,
                  "hits, triangles, nodes or pairs that one answer lists");
  maker.add_count("--max-loads", command.limits.loads,
                  "loads of scenes that run or wait; two scenes are built at a time");
  app.add_option(
         "--skip", flags.skip,
         "'all': trees are built when queries need them, or in the background; 'none': before "
         "a scene is ready. No answer depends on it")
      ->check(CLI::IsMember({"all", "none"}))
      ->capture_default_str();
  maker
      .add_count("--memory-budget", command.limits.memory_budget,
                 "bytes of all scenes with their trees; beyond it the trees of the least recently "
                 "used scenes are evicted, and the rest is in temporary files (default: half of "
                 "the machine's memory)")
      ->default_str("");
  maker.add_count("--disk-budget", command.limits.disk_budget,
                  "bytes of trees stored in --data; beyond it those of the least recently used "
                  "scenes are removed, and built again when they are needed; also of the temporary "
                  "files beyond --memory-budget");
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
                 "non-public addresses that those URLs may have, like 10.0.0.0/8; without it only "
                 "public addresses are allowed (repeatable)")
      ->take_all()
      ->type_name("RANGE");
  maker.add_seconds("--origin-seconds", flags.origin_seconds, kLeastSeconds,
                    "time between two checks of what other servers have changed in the origin");
  maker
      .add_count(
          "--cache-bytes", command.cache_bytes,
          "bytes of files in --data if there is an origin; beyond it the least recently used "
          "scenes leave this server, but not the origin (default: no limit)")
      ->default_str("");
  maker.add_live_seconds("--request-seconds", flags.request_seconds, kLeastSeconds,
                         "longest time to answer a request");
  maker.add_seconds("--fetch-seconds", flags.fetch_seconds, kLeastSeconds,
                    "longest time to fetch a URL, with all redirects");
  maker.add_live_seconds("--drain-seconds", flags.drain_seconds, 0,
                         "longest time that a shutdown waits for running requests");
  maker.add_live_seconds("--notice-seconds", flags.notice_seconds, 0,
                         "time that /readyz answers 503 before a shutdown, for load balancers");
  command.http.memory = std::max(std::uint64_t{256} << 20, machine_memory() / 8);
  command.limits.memory_budget = machine_memory() / 2;
  define_http_flags(app, command.http, flags.http);
}

void finish_serve(ServeCommand& command, const ServeFlags& flags) {
  auto listen = parse_listen_address(flags.listen);
  if (!listen) throw CLI::ValidationError("--listen", listen.error().message);
  command.listen = std::move(*listen);
  for (const std::string& preload : flags.preloads) {
    command.preloads.push_back(parse_preload(preload));
    const std::string& name = command.preloads.back().first;
    if (std::any_of(command.preloads.begin(), command.preloads.end() - 1,
                    [&](const auto& other) { return other.first == name; })) {
      throw CLI::ValidationError("--preload", "'" + name + "' is given twice");
    }
  }
  command.urls.patterns = parse_each<UrlPattern>(flags.allow_urls, "--allow-url");
  command.urls.addresses = parse_each<AddressRange>(flags.allow_addresses, "--allow-address");
  command.urls.time = milliseconds_of(flags.fetch_seconds);
  command.urls.agent = "sightline/" + version();
  // Each of these holds a worker.
  command.limits.waiters = command.http.workers / 2;
  command.log_format = flags.log_format == "json" ? LogFormat::kJson : LogFormat::kText;
  command.laziness = flags.skip == "none" ? Laziness::kEager : Laziness::kWhenNeeded;
  command.limits.request = milliseconds_of(flags.request_seconds);
  command.origin_refresh = milliseconds_of(flags.origin_seconds);
  finish_http_flags(command.http, flags.http);
  command.limits.uploads = command.http.memory;
  command.limits.drain = milliseconds_of(flags.drain_seconds);
  command.limits.notice = milliseconds_of(flags.notice_seconds);
}

void check_together(const ServeCommand& command) {
  if (!command.origin.empty() && command.data.empty()) {
    throw CLI::ValidationError("--origin", "needs a folder for its cache: --data");
  }
  if (command.keys.empty() && !command.insecure && !is_local_host(command.listen.host)) {
    throw CLI::ValidationError("--listen", "other machines can reach " + command.listen.host +
                                               ": give a file of keys with --keys, or allow "
                                               "every client everything with --insecure");
  }
}

std::vector<std::string> warnings_of(const ServeCommand& command) {
  if (!command.keys.empty() || command.cors_origins.empty()) return {};
  return {"--cors-origin: without --keys pages of these origins may also change scenes"};
}

std::vector<FlagText> flag_texts(const CLI::App& app) {
  std::vector<FlagText> texts;
  for (const CLI::Option* option : app.get_options()) {
    const auto& given = option->results();
    texts.push_back({option->get_single_name(),
                     given.empty() ? option->get_default_str() : CLI::detail::join(given, " "),
                     option->get_group() == kLiveFlags});
  }
  return texts;
}

}  // namespace sightline
