// Bodies of boxes of any kind, for scenes and for rays: an error with a place, or boxes that have
// passed the border and that the exact predicates can answer.
// Run:  scripts/stress.sh fuzz --target box_json_fuzz

#include <cmath>
#include <cstdint>
#include <string>

#include "core/geometry/ray_box.h"
#include "proto/json/box_json.h"
#include "proto/json/ray_box_json.h"
#include "tests/fuzz/body_check.h"

namespace {

using namespace sightline;
using Json = nlohmann::json;

using fuzz::check_error;
using fuzz::require;

void check_boxes_of(const BoxBatch& boxes, const std::string& sent) {
  BoxFault fault;
  require(check_boxes(boxes, fault), "boxes have passed the border");
  require(boxes.size() <= 64, "limits hold");
  const Json document = Json::parse(sent, nullptr, false);
  require(document.is_object() && document["boxes"].size() == boxes.size(),
          "what is accepted is JSON with as many boxes");
}

void check_pairs(const RayBoxQuery& query) {
  RayBoxAnswers answers;
  const std::size_t count = query.pairing == BoxPairing::kEach
                                ? query.rays.size()
                                : query.rays.size() * query.boxes.size();
  require(count <= 256, "limits hold");
  answers.resize(count, RayBoxDetail::kAll);
  for (std::size_t i = 0; i < count; ++i) {
    const bool each = query.pairing == BoxPairing::kEach;
    const Ray ray = query.rays[each ? i : i / query.boxes.size()];
    const RayBoxAnswer answer =
        query.boxes.visit_box(each ? i : i % query.boxes.size(), [&](const auto& box) {
          return ray_box(ray.origin, ray.direction, ray.tmin, ray.tmax, box);
        });
    require(!std::isnan(answer.t) && !std::isnan(answer.t_enter) && !std::isnan(answer.t_exit),
            "no answer is NaN");
    require(answer.outcome != RayBoxOutcome::kHit || answer.t_enter <= answer.t_exit,
            "a ray enters before it leaves");
    answers.outcome[i] = answer.outcome;
    answers.apart[i] = answer.apart;
    answers.faces[i] = answer.faces;
    answers.t[i] = answer.t;
  }
  require(Json::accept(encode_ray_boxes(answers)), "answers are JSON");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string sent(reinterpret_cast<const char*>(data), size);
  std::string body = sent;
  const auto pairs = decode_ray_boxes(body, {.max_rays = 64, .max_boxes = 64, .max_pairs = 256});
  require(body == sent, "the body is only read");
  if (pairs) {
    check_boxes_of(pairs->boxes, sent);
    check_pairs(*pairs);
  } else {
    check_error(pairs.error());
  }
  const auto query = decode_boxes(body, {.max_boxes = 64, .limit = 1000});
  require(body == sent, "the body is only read");
  if (query) {
    check_boxes_of(query->boxes, sent);
    require(query->limit <= 1000, "limits hold");
  } else {
    check_error(query.error());
  }
  return 0;
}
