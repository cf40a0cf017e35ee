#include "server/operation/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <array>
#include <atomic>
#include <map>
#include <mutex>
#include <tuple>
#include <vector>

#include "core/store/scene_store.h"
#include "server/operation/version.h"

namespace sightline {
namespace {

using prometheus::MetricFamily;
using prometheus::MetricType;

/// From a trivial request to the longest that tracing may take.
const prometheus::Histogram::BucketBoundaries& buckets() {
  static const prometheus::Histogram::BucketBoundaries kBuckets{
      0.0001, 0.00025, 0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05,
      0.1,    0.25,    0.5,    1,     2.5,    5,     10,   30,    60};
  return kBuckets;
}

/// A gauge (or counter) with one label, made at the moment of asking.
MetricFamily family(const char* name, const char* help, MetricType type, const char* label,
                    const std::vector<std::pair<std::string, double>>& values) {
  MetricFamily result;
  result.name = name;
  result.help = help;
  result.type = type;
  for (const auto& [value_of_label, value] : values) {
    prometheus::ClientMetric metric;
    if (*label != '\0') metric.label = {{label, value_of_label}};
    if (type == MetricType::Counter) {
      metric.counter.value = value;
    } else {
      metric.gauge.value = value;
    }
    result.metric.push_back(std::move(metric));
  }
  return result;
}

using Values = std::vector<std::pair<std::string, double>>;

template <class Number>
MetricFamily gauge(const char* name, const char* help, Number value) {
  return family(name, help, MetricType::Gauge, "", {{"", static_cast<double>(value)}});
}

Values as_values(const NamedCounts& counts) {
  Values values;
  for (const auto& [name, count] : counts) values.emplace_back(name, static_cast<double>(count));
  return values;
}

MetricFamily counters(const char* name, const char* help, const char* label,
                      const NamedCounts& counts) {
  return family(name, help, MetricType::Counter, label, as_values(counts));
}

void add(Values& sums, const NamedCounts& counts) {
  if (sums.empty()) sums = as_values(NamedCounts(counts.size()));
  for (std::size_t i = 0; i < counts.size(); ++i) {
    sums[i].first = counts[i].first;
    sums[i].second += static_cast<double>(counts[i].second);
  }
}

using Families = std::vector<MetricFamily>;

void add_store(const SceneStore& store, Families& families) {
  Values states{{"queued", 0}, {"loading", 0}, {"ready", 0}, {"failed", 0}, {"stored", 0}}, touched,
      skipped;
  std::uint64_t triangles = 0;
  for (const SceneSnapshot& scene : store.list()) {
    ++states[static_cast<std::size_t>(scene->state)].second;
    if (!scene->scene) continue;
    triangles += scene->scene->instanced_triangle_count();
    add(touched, touched_counts(*scene->scene));
    add(skipped, skipped_counts(*scene->scene));
  }
  const auto labelled = [&](const char* name, const char* help, const char* label,
                            const Values& values) {
    families.push_back(family(name, help, MetricType::Gauge, label, values));
  };
  labelled("sightline_scenes", "Scenes by state.", "state", states);
  families.push_back(gauge("sightline_triangles",
                           "Triangles of all ready scenes, each placement counted.", triangles));
  labelled("sightline_bytes_touched",
           "Bytes of the files of ready scenes that were read, by what they are.", "kind", touched);
  labelled("sightline_skipped", "Parts of the files of ready scenes that were not read.", "what",
           skipped);
  families.push_back(counters("sightline_loads_total", "Loads that ended, by outcome.", "outcome",
                              store.load_counts()));
  families.push_back(gauge("sightline_origin_failing",
                           "1 if the origin failed at the last check, else 0.",
                           store.is_origin_failing() ? 1 : 0));
}

void add_trees(const TreeTotals& trees, Families& families) {
  families.insert(
      families.end(),
      {counters("sightline_tree_builds_total",
                "Trees built for queries (near), and scenes whose trees were all built at once "
                "(scene).",
                "of", {{"near", trees.trees_built}, {"scene", trees.full_builds}}),
       counters("sightline_tree_evictions_total",
                "Scenes whose trees were evicted for lack of memory.", "", {{"", trees.evictions}}),
       counters("sightline_tree_files_total",
                "Files of trees that were read, and those that were refused.", "outcome",
                {{"read", trees.cache_hits}, {"refused", trees.cache_rejects}}),
       counters("sightline_tree_waits_total", "Rays and boxes that waited for an unbuilt tree.", "",
                {{"", trees.queries_waited}}),
       gauge("sightline_tree_bytes", "Bytes of all trees that are built now.", trees.tree_bytes),
       gauge("sightline_geometry_bytes",
             "Bytes of positions and indices in memory; shared data counts once.",
             trees.geometry_bytes),
       gauge("sightline_overflow_bytes",
             "Bytes of geometry and trees beyond --memory-budget, in temporary files.",
             trees.overflow_bytes),
       counters("sightline_overflow_evicted_bytes_total",
                "Bytes of these files that were unmapped to stay within --memory-budget.", "",
                {{"", trees.evicted_bytes}})});
}

void add_process(double start, const ServerNow& now, Families& families) {
  MetricFamily build = family("sightline_build_info", "Version and kernel of the server.",
                              MetricType::Gauge, "version", {{version(), 1}});
  build.metric[0].label.push_back({"kernel", now.kernel});
  families.insert(
      families.end(),
      {gauge("sightline_connections", "Open connections.", now.connections),
       counters("sightline_connections_total",
                "Connections: accepted, closed to make room (evicted), too slow, or closed by the "
                "client before the answer. Requests: refused for their framing, for lack of a "
                "sufficient key (locked_out) or for a full queue, or answered by the event loop.",
                "event", now.events),
       gauge("sightline_queued_requests", "Requests that wait for a worker.", now.queued),
       gauge("sightline_traffic_bytes", "Bytes of memory of connections and requests.",
             now.traffic),
       gauge("sightline_spool_bytes", "Bytes of temporary files of bodies and answers.",
             now.spooled),
       gauge("sightline_send_buffer_bytes",
             "Of answers that the kernel holds until clients acknowledge them.", now.send_buffers),
       std::move(build),
       gauge("process_start_time_seconds", "When the server was started, in seconds since 1970.",
             start)});
}

}  // namespace

std::string_view known_method(std::string_view method) {
  for (const std::string_view each : {"GET", "HEAD", "PUT", "POST", "PATCH", "DELETE", "OPTIONS"}) {
    if (method == each) return each;
  }
  return "other";
}

struct Metrics::State {
  prometheus::Registry registry;
  prometheus::Family<prometheus::Counter>& counter(const char* name, const char* help) {
    return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
  }
  prometheus::Family<prometheus::Counter>& requests =
      counter("sightline_requests_total", "Requests answered, by method, route and status.");
  prometheus::Family<prometheus::Histogram>& seconds =
      prometheus::BuildHistogram()
          .Name("sightline_request_seconds")
          .Help("Time from the head of a request to its answer, by route. A stream ends later.")
          .Register(registry);
  prometheus::Counter& rays = counter("sightline_rays_total", "Rays in requests.").Add({});
  prometheus::Counter& boxes = counter("sightline_boxes_total", "Boxes in requests.").Add({});
  prometheus::Family<prometheus::Counter>& work = counter(
      "sightline_work_total",
      "Cost of queries: tree nodes and blocks of triangles that were tested, placements of meshes "
      "that were entered. Exact decisions: triangles, orders of two hits, and roundings.");
  prometheus::Counter& of_work(const char* what) { return work.Add({{"what", what}}); }
  /// Each with what QueryWork counts of it.
  const std::array<std::pair<std::uint64_t QueryWork::*, prometheus::Counter&>, 6> works{
      {{&QueryWork::nodes, of_work("nodes")},
       {&QueryWork::blocks, of_work("blocks")},
       {&QueryWork::placements, of_work("placements")},
       {&QueryWork::exact_hits, of_work("exact_hits")},
       {&QueryWork::exact_compares, of_work("exact_compares")},
       {&QueryWork::exact_roundings, of_work("exact_roundings")}}};

  struct Series {
    prometheus::Counter* requests;
    prometheus::Histogram* seconds;
  };
  /// Method, route and status; the texts outlive this.
  using Key = std::tuple<std::string_view, std::string_view, int>;
  /// The library finds a series by a map of texts, which would have to be made for each request.
  Series series_of(const Key& key) {
    const std::lock_guard hold(mutex);
    const auto known = found.find(key);
    if (known != found.end()) return known->second;
    const auto& [method, route, status] = key;
    const Series made{&requests.Add({{"method", std::string(method)},
                                     {"route", std::string(route)},
                                     {"status", std::to_string(status)}}),
                      &seconds.Add({{"route", std::string(route)}}, buckets())};
    return found.emplace(key, made).first->second;
  }
  std::mutex mutex;
  std::map<Key, Series> found;
  std::atomic<std::uint64_t> slow{0};
  const double start =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
};

Metrics::Metrics() : state_(std::make_unique<State>()) {}
Metrics::~Metrics() = default;

void Metrics::count(const Request& request) {
  const State::Series series =
      state_->series_of({known_method(request.method),
                         request.route.empty() ? "none" : request.route, request.status});
  series.requests->Increment();
  if (request.time.count() > 0) series.seconds->Observe(request.time.count());
  state_->boxes.Increment(static_cast<double>(request.boxes));
  count_part(request.rays, request.work);
}

void Metrics::count_part(std::uint64_t rays, const QueryWork& work) const {
  state_->rays.Increment(static_cast<double>(rays));
  for (const auto& [count, counter] : state_->works) {
    if (work.*count > 0) counter.Increment(static_cast<double>(work.*count));
  }
}

void Metrics::count_slow() const { ++state_->slow; }
std::uint64_t Metrics::slow() const { return state_->slow; }

std::string Metrics::text(const SceneStore& store, const ServerNow& now) const {
  Families families = state_->registry.Collect();
  add_store(store, families);
  add_trees(now.trees, families);
  add_process(state_->start, now, families);
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace sightline
