#include "server/serve.h"

#include <spdlog/sinks/stdout_sinks.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <system_error>
#include <thread>

#include "core/run/engine.h"
#include "core/store/scene_store.h"
#include "core/store/tree_cache_manager.h"
#include "server/http/ip_address.h"
#include "server/http/spool.h"
#include "server/operation/progress_bar.h"
#include "server/operation/reload.h"
#include "server/operation/request_log.h"
#include "server/operation/serve_flags.h"
#include "server/operation/signals.h"
#include "server/operation/system_limits.h"
#include "server/operation/version.h"
#include "server/routes/request_weight.h"
#include "server/routes/routes.h"
#include "server/routes/routes_jobs.h"
#include "server/service/scene_source.h"
#include "server/sources/origin_choice.h"

namespace sightline {
namespace {

TreeCacheOptions tree_cache_options(const ServeCommand& command,
                                    std::shared_ptr<OriginScenes> origin, Log& log) {
  TreeCacheOptions options;
  options.ahead = command.laziness == Laziness::kWhenNeeded;
  options.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / 4);
  if (!command.data.empty()) options.folder = std::filesystem::path(command.data) / "trees";
  options.disk_budget = command.limits.disk_budget;
  options.origin = std::move(origin);
  options.memory_budget = command.limits.memory_budget;
  // A scene that an origin has is dropped instead, and fetched again.
  if (options.memory_budget > 0 && command.origin.empty()) {
    options.overflow = OverflowMemory::make(
        command.data.empty() ? command.http.spool_folder : command.data, options.disk_budget);
  }
  options.report = [&log](const std::string& line) { log.warn(line); };
  return options;
}

/// Loads a scene and adopts it. load(overflow_for) returns a PreloadedScene or a scene, `scene_of` the
/// scene in it. Where another load has taken the room meanwhile, loads it again to overflow memory.
template <class Load, class SceneOf>
auto load_and_adopt(TreeCacheManager& manager, const std::string& sha256, const Load& load,
                    const SceneOf& scene_of) -> decltype(load(OverflowFor())) {
  auto loaded = load([&](std::uint64_t bytes) { return manager.overflow_for(bytes); });
  if (!loaded) return loaded;
  Status adopted = manager.adopt(scene_of(*loaded), sha256);
  if (adopted) return loaded;
  auto overflow = manager.overflow_for(std::numeric_limits<std::uint64_t>::max());
  if (overflow == nullptr) return std::move(adopted).error();
  loaded = load([&](std::uint64_t) { return overflow; });
  if (!loaded) return loaded;
  adopted = manager.adopt(scene_of(*loaded), sha256);
  if (!adopted) return std::move(adopted).error();
  return loaded;
}

std::vector<Preload> preloads_of(const ServeCommand& command, TreeCacheManager& manager) {
  std::vector<Preload> preloads;
  for (const auto& [id, source] : command.preloads) {
    preloads.push_back({id, [&, source = source](Progress& progress) -> Result<PreloadedScene> {
                          const auto load = [&](const OverflowFor& overflow_for) {
                            return load_source(source, {}, progress, command.laziness, true,
                                               overflow_for);
                          };
                          return load_and_adopt(manager, {}, load,
                                                [](const auto& loaded) { return loaded.scene; });
                        }});
  }
  return preloads;
}

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value != nullptr ? value : "";
}

Result<std::shared_ptr<const SourceRules>> sources_of(const ServeCommand& command) {
  auto rules = std::make_shared<SourceRules>();
  rules->urls = command.urls;
  if (!command.scene_root.empty()) {
    auto root = SceneRoot::open(command.scene_root);
    if (!root) return std::move(root).error();
    rules->root.emplace(std::move(*root));
  }
  return std::shared_ptr<const SourceRules>(std::move(rules));
}

/// Of the first scene of the start that is still on its way, and how many there are.
std::optional<std::string> loading_line(const SceneStore& store) {
  if (store.settled()) return std::nullopt;
  std::string line;
  std::size_t moving = 0;
  for (const SceneSnapshot& scene : store.list()) {
    if (scene->state == SceneState::kLoading && line.empty()) {
      line = scene->id + ": " + progress_line(scene->progress);
    }
    if (scene->is_moving()) ++moving;
  }
  return moving > 1 ? line + " (" + std::to_string(moving) + " scenes to come)" : line;
}

/// Answers a request by its route, or makes a job of it.
struct Answerer {
  const Router& router;
  const Service& service;
  const Journal& journal;
  std::optional<JobBoard> jobs = {};

  void operator()(Exchange& exchange) {
    if (!answer_as_job(exchange, service, *jobs)) router.dispatch(exchange);
  }
};

/// One request, from its route to its line in the log.
void answer(Answerer& answerer, Exchange& exchange) {
  const Journal& journal = answerer.journal;
  const auto note = [&](int status) {
    note_request(journal, exchange, status, std::chrono::steady_clock::now() - exchange.asked_at);
  };
  try {
    answerer(exchange);
  } catch (const std::bad_alloc&) {
    if (!exchange.on_event_loop) note(507);
    throw;
  } catch (...) {
    if (!exchange.on_event_loop) note(500);
    throw;
  }
  if (!exchange.is_put_off()) note(exchange.response.status);
}

/// The request of a job, on the job's thread.
void answer_job(Answerer& answerer, Log& log, Exchange& exchange) {
  exchange.asked_at = std::chrono::steady_clock::now();
  try {
    answer(answerer, exchange);
  } catch (const std::bad_alloc&) {
    exchange.response = {};
    exchange.reply_problem(507, "MEMORY_FULL", "there is no memory left for this request");
  } catch (...) {
    exchange.response = {};
    log.error("job failed by an exception", {{"id", exchange.request_id}});
    exchange.reply_problem(500, "INTERNAL", "the server failed to answer; the fault is its own");
  }
}

NamedCounts connection_events(const EventLoopCounts& counts, const Metrics& metrics) {
  return {{"accepted", counts.accepted},
          {"evicted", counts.evicted},
          {"too_slow", counts.timed_out + metrics.slow()},
          {"gone", counts.gone},
          {"refused", counts.refused},
          {"locked_out", counts.locked_out},
          {"queue_full", counts.overload},
          {"answered_in_event_loop", counts.answered}};
}

/// The next signal but SIGHUP, wake(), or the end of `timeout`.
Signals::Event wait_for_stop(Signals& signals, std::chrono::milliseconds timeout) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + timeout;
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
    const auto event = signals.wait(std::max(left, std::chrono::milliseconds(0)));
    if (event != Signals::Event::kReload) return event;
  }
}

/// Turns signals into the steps of a stop: announce it, accept no more connections, cancel what is left.
void watch_signals(Signals& signals, const Running& running) {
  using Event = Signals::Event;
  Service& service = running.service;
  Event event = signals.wait(std::nullopt);
  for (; event == Event::kReload; event = signals.wait(std::nullopt)) reload(running);
  if (event == Event::kWoken) return;
  running.log.info("stopping");
  service.stopping = true;
  // A load balancer sees /readyz turn before connections are refused.
  const ServeCommand& command = running.command;
  event = Event::kTimeout;
  if (command.limits.notice.get().count() > 0) {
    event = wait_for_stop(signals, command.limits.notice);
  }
  if (event == Event::kWoken) return;
  running.server.stop();
  // A second signal does not wait for anything.
  if (event != Event::kStop) event = wait_for_stop(signals, command.limits.drain);
  if (event == Event::kWoken) return;
  running.log.warn("aborting requests that have not ended");
  service.cancelled.cancel();
  running.server.break_connections();
}

/// While everything is taken down: a signal ends the process, whose data folder is whole at any
/// moment. Nobody has to wait for what a builder or a disk takes its time for.
class LastWatch {
 public:
  LastWatch(Signals& signals, EndNow end_now)
      : signals_(signals), end_now_(std::move(end_now)), thread_([this] { watch(); }) {}
  ~LastWatch() {
    done_ = true;
    signals_.wake();
    thread_.join();
  }
  LastWatch(const LastWatch&) = delete;
  LastWatch& operator=(const LastWatch&) = delete;

 private:
  void watch() {
    // The watcher before may have left a wake that was meant for it.
    while (!done_) {
      if (signals_.wait(std::nullopt) == Signals::Event::kStop) end_now_(signals_.let_through());
    }
  }

  Signals& signals_;
  const EndNow end_now_;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

/// All that a server is made of is gone when it returns. The exit code; where it has served,
/// `last_watch` is there from the end of that.
int serve(ServeCommand command, Signals& signals, Log& log, std::optional<LastWatch>& last_watch,
          const EndNow& end_now, std::ostream& out, std::ostream& complaints) {
  // `where`: the flag and what it names.
  const auto complain = [&](const Error& error, const std::string& where = "") {
    complaints << "sightline: " << error.code << ": " << where << error.message << "\n";
    return 2;
  };
  AccessRules access;
  if (!command.keys.empty()) {
    if (Status taken = take_keys(command.keys, access, log); !taken) {
      return complain(taken.error(), "--keys " + command.keys + ": ");
    }
  }
  std::atomic<bool> should_yield{false};
  auto engine = Engine::create(
      {.threads = command.threads, .kernel = command.kernel, .should_yield = &should_yield});
  if (!engine) return complain(engine.error());
  StoreOptions options;
  options.folder = command.data;
  options.loads_max = command.limits.loads;
  options.uploads_memory = command.limits.uploads;
  options.report = [&log, &access](const std::string& id, const Error& error) {
    const std::string shown = access.is_key(id) ? "" : id;
    log.error("scene failed", {{"scene", shown}, {"code", error.code}, {"reason", error.message}});
  };
  if (!command.origin.empty()) {
    auto origin = open_origin(command.origin, command.origin_credentials, variable);
    if (!origin) return complain(origin.error(), "--origin: ");
    options.shared = {std::make_shared<OriginScenes>(std::move(*origin)), command.origin,
                      command.origin_refresh, command.cache_bytes,
                      [&log](const std::string& line) { log.warn(line); }};
    // It may be down at this moment: the servers answer from their caches.
    if (const Status safe = options.shared.origin->probe(); !safe) {
      log.warn("--origin: " + safe.error().code + ": " + safe.error().message);
    }
  }
  TreeCacheManager manager(tree_cache_options(command, options.shared.origin, log));
  options.admit = [&manager](const std::shared_ptr<const Scene>& scene) {
    return manager.adopt(scene, {}, false);
  };
  options.overflow_for = [&manager](std::uint64_t bytes) { return manager.overflow_for(bytes); };
  const auto load = [&](const LoadInput& input) {
    const auto read = [&](const OverflowFor& overflow_for) {
      return load_scene(input, command.laziness, overflow_for);
    };
    return load_and_adopt(manager, input.sha256, read, [](const auto& scene) { return scene; });
  };
  auto store = SceneStore::open(options, load, preloads_of(command, manager));
  if (!store) {
    return complain(store.error(), command.data.empty() ? "" : "--data " + command.data + ": ");
  }

  if (const Status spool = SpoolFile::can_be_made_in(command.http.spool_folder); !spool) {
    return complain(spool.error(), "--spool-dir: ");
  }
  command.http.connections = allowed_connections(command.http);
  command.http.request = std::min(command.http.request, machine_memory() / 2);
  Service service{**engine, **store, command.limits};
  Metrics metrics;
  const Journal journal{log, metrics};
  const ProgressBar bar([&store] { return loading_line(**store); });
  auto sources = sources_of(command);
  if (!sources) return complain(sources.error());
  Router router;
  add_scene_routes(router, service, *sources);
  add_node_routes(router, service);
  add_ray_routes(router, service, journal);
  add_clearance_routes(router, service);
  add_sweep_routes(router, service);
  add_visibility_routes(router, service);
  add_point_routes(router, service);
  add_scene_part_routes(router, service);
  add_box_routes(router, service);
  add_page_routes(router);
  const AnswerHeaders headers(command.cors_origins);
  for (const std::string& warning : warnings_of(command)) log.warn(warning);
  const bool for_this_machine = is_local_host(command.listen.host);
  const EventLoopCallbacks rules{
      headers,
      [&](RequestHead& head) {
        auto fault = access.admit(head);
        if (headers.is_preflight(head)) fault.reset();
        if (command.keys.empty() && headers.is_strange_page(head)) {
          fault = {403, "ORIGIN_NOT_ALLOWED", "only pages that --cors-origin names may ask"};
        } else if (command.keys.empty() && for_this_machine && headers.is_strange_name(head)) {
          fault = {403, "HOST_NOT_ALLOWED",
                   "without keys the server answers to localhost, to addresses and to the hosts "
                   "that --cors-origin names"};
        }
        return fault;
      },
      weigh_request,
      holds_key,
      &should_yield,
      [&](const RequestHead& head, const RequestFault& fault, const std::string& id) {
        // A head with a fault has not been through admit().
        note_refusal(journal, head, fault, access.is_key(id) ? std::string() : id);
      }};
  Answerer answerer{router, service, journal};
  HttpServer server(
      command.http, [&](Exchange& exchange) { answer(answerer, exchange); },
      [&](const std::string& id, const std::string& type) {
        log.error("request failed by an exception", {{"id", id}, {"type", type}});
      },
      rules);
  const auto now = [&] {
    return ServerNow{server.counts().open, connection_events(server.counts(), metrics),
                     server.queued(),      server.memory(),
                     server.spooled(),     server.counts().send_buffers,
                     manager.totals(),     (*engine)->kernel()};
  };
  const JobLimits job_limits{.bytes = command.http.memory / 4};
  answerer.jobs.emplace(job_limits, server.budget(),
                        [&](Exchange& exchange) { answer_job(answerer, log, exchange); });
  add_job_routes(router, *answerer.jobs);
  add_health_routes(router, service, {metrics, command.http, **sources, now});
  const auto port = server.bind(command.listen);
  if (!port) return complain(port.error(), port.error().code == "THREADS_FEW" ? "--workers: " : "");

  const Running running{command, access, service, server, log};
  std::thread watcher([&] { watch_signals(signals, running); });
  const bool v6 = command.listen.host.find(':') != std::string::npos;
  out << "listening on http://" << (v6 ? "[" : "") << command.listen.host << (v6 ? "]" : "") << ":"
      << *port << std::endl;
  log.info("serving", {{"version", version()},
                       {"kernel", (*engine)->kernel()},
                       {"threads", std::int64_t{(*engine)->threads()}}});
  server.serve();
  answerer.jobs.reset();
  signals.wake();
  watcher.join();
  last_watch.emplace(signals, end_now);
  return 0;
}

}  // namespace

int run_serve(const ServeCommand& command, const EndNow& end_now, std::ostream& out,
              std::ostream& complaints) {
  Signals signals;
  Log log(command.log_format, command.log_level, std::make_shared<spdlog::sinks::stderr_sink_mt>());
  std::optional<LastWatch> last_watch;
  const int code = serve(command, signals, log, last_watch, end_now, out, complaints);
  last_watch.reset();
  if (code == 0) log.info("stopped");
  return code;
}

}  // namespace sightline
