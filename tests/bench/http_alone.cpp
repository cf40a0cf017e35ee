#include "tests/bench/http_alone.h"

#include <stdexcept>

#include "proto/binary/hit_binary.h"
#include "proto/binary/ray_binary.h"
#include "proto/json/hit_lines.h"
#include "proto/json/ray_lines.h"
#include "server/service/hit_terms.h"
#include "tests/bench/machine.h"

namespace sightline::bench {
namespace {

RayQuery decode(std::string& body, Form form) {
  auto query = form == Form::kBinary  ? decode_rays_binary(body, {})
               : form == Form::kLines ? RayLines({}).decode(body)
                                      : decode_rays(body, {});
  if (!query) throw std::runtime_error("a body is refused: " + query.error().message);
  return std::move(*query);
}

std::string encode(const Scene& scene, const RayQuery& query, const HitBatch& hits) {
  const HitTerms terms = hit_terms(scene, hits, query.fields);
  if (query.layout == AnswerLayout::kBinary) {
    return encode_hits_binary(hits, {}, terms, query.fields, nullptr);
  }
  if (query.layout == AnswerLayout::kLines) {
    return encode_hit_lines(hits, {}, terms, query.fields, nullptr);
  }
  return encode_hits(hits, {}, terms, query.fields, query.layout);
}

}  // namespace

AloneTimes measure_alone(const Engine& engine, const Scene& scene, const std::string& body,
                         Form form, double seconds, std::string& answer) {
  AloneTimes times;
  double rays = 0;
  const double begin = wall_time_seconds();
  do {
    std::string copy = body;  // what a server has read
    HitBatch hits;
    const double before = thread_time_ns();
    const RayQuery query = decode(copy, form);
    const double decoded = thread_time_ns();
    if (!engine.closest(scene, query.rays, Deadline::never(), hits)) {
      throw std::runtime_error("the engine refuses");
    }
    const double traced = thread_time_ns();
    answer = encode(scene, query, hits);
    const double encoded = thread_time_ns();
    times.decode += decoded - before;
    times.trace += traced - decoded;
    times.encode += encoded - traced;
    rays += static_cast<double>(hits.size());
  } while (wall_time_seconds() - begin < seconds);
  return {times.decode / rays, times.trace / rays, times.encode / rays};
}

}  // namespace sightline::bench
