#pragma once
/// The same work without a server: on one thread, by its own processor time.

#include <string>

#include "core/run/engine.h"
#include "core/scene/scene.h"
#include "tests/bench/http_bodies.h"

namespace sightline::bench {

/// Nanoseconds for each ray.
struct AloneTimes {
  double decode = 0, trace = 0, encode = 0;
  double sum() const { return decode + trace + encode; }
};

/// Decodes, traces and encodes `body` until `seconds` have passed, each step timed by itself.
/// `answer` is what a server sends for it. Precondition: the body is one of body_of.
AloneTimes measure_alone(const Engine& engine, const Scene& scene, const std::string& body,
                         Form form, double seconds, std::string& answer);

}  // namespace sightline::bench
