#include "proto/json/ray_box_json.h"

#include <array>
#include <cmath>
#include <limits>

#include "core/base/infinity.h"
#include "proto/json/box_rows.h"
#include "proto/json/json_writer.h"
#include "proto/json/ray_reader.h"

namespace sightline {

namespace {

constexpr std::array<std::string_view, 4> kRayBoxKeys{"boxes", "pairing", "line", "planes"};

class RayBoxReader : public RayReader {
 public:
  explicit RayBoxReader(const RayBoxJsonRules& rules)
      : RayReader({.max_rays = rules.max_rays,
                   .has_fields = false,
                   .has_scene = false,
                   .has_timeout = true,
                   .has_generator = false}),
        rules_(rules) {
    // Which limit stands for none is known when "line" has been read.
    default_tmin_ = std::numeric_limits<double>::quiet_NaN();
  }

  Result<RayBoxQuery> read_all(std::string& body) {
    Result<RayQuery> rays = read(body);
    if (!rays) return std::move(rays).error();
    query_boxes_.rays = std::move(rays->rays);
    query_boxes_.timeout_ms = rays->timeout_ms;
    query_boxes_.threads = rays->threads;
    return std::move(query_boxes_);
  }

 private:
  std::span<const std::string_view> more_keys() const override {
    static_assert(kRayBoxKeys.size() <= kMostMoreKeys);
    return kRayBoxKeys;
  }

  bool read_more(std::size_t which, Value value) override {
    const JsonPointer place = JsonPointer().key(kRayBoxKeys[which]);
    if (which == 0) {
      has_boxes_ = true;
      return BoxRows(*this, rules_.max_boxes, BoxRows::Takes::kBoxes)
          .read(value, query_boxes_.boxes);
    }
    if (which == 1) {
      constexpr std::array<std::string_view, 2> kWords{"each", "all"};
      std::size_t word = 0;
      if (!read_word(value, kWords, word, place)) return false;
      query_boxes_.pairing = word == 1 ? BoxPairing::kAll : BoxPairing::kEach;
      return true;
    }
    return read_boolean(value, which == 2 ? line_ : query_boxes_.planes, place);
  }

  bool finish_more() override {
    if (!has_boxes_) return invalid("KEY_MISSING", "needs \"boxes\"", {});
    for (double& tmin : query_.rays.tmin) {
      if (std::isnan(tmin)) tmin = line_ ? -kInf : 0.0;
    }
    const std::size_t rays = query_.rays.size(), boxes = query_boxes_.boxes.size();
    if (query_boxes_.pairing == BoxPairing::kEach && rays != boxes) {
      return invalid("PAIRS_UNEQUAL",
                     "\"each\" needs as many boxes as rays, has " + std::to_string(rays) +
                         " rays and " + std::to_string(boxes) +
                         " boxes; \"pairing\":\"all\" takes every ray with every box",
                     JsonPointer().key("boxes"));
    }
    const std::size_t times = query_boxes_.pairing == BoxPairing::kAll ? boxes : 1;
    if (times > 0 && rays > rules_.max_pairs / times) {
      return fail(ErrorKind::kTooLarge, "PAIRS_TOO_MANY",
                  std::to_string(rays) + " rays and " + std::to_string(boxes) +
                      " boxes are more than the " + std::to_string(rules_.max_pairs) +
                      " pairs that a request may have",
                  JsonPointer().key("boxes"));
    }
    return true;
  }

  RayBoxJsonRules rules_;
  RayBoxQuery query_boxes_;
  bool has_boxes_ = false;
  bool line_ = false;
};

void write_face(JsonWriter& out, BoxFace face) {
  out.raw(face.upper ? "\"+" : "\"-");
  out.raw("xyz"[face.axis]);
  out.raw('"');
}

void write_span(JsonWriter& out, const RayBoxAnswers& answers, std::size_t i) {
  out.raw(",\"t_enter\":");
  out.number(answers.t_enter[i]);
  out.raw(",\"t_exit\":");
  out.number(answers.t_exit[i]);
  out.raw(",\"inside\":");
  out.boolean(answers.inside[i] != 0);
  out.raw(",\"on_surface\":");
  out.boolean(answers.on_surface[i] != 0);
}

void write_hit(JsonWriter& out, const RayBoxAnswers& answers, std::size_t i) {
  const BoxFaces& faces = answers.faces[i];
  out.raw("\"hit\":true,\"t\":");
  out.number(answers.t[i]);
  write_span(out, answers, i);
  out.raw(",\"face\":");
  if (faces.count > 0) {
    write_face(out, faces.face[0]);
  } else {
    out.raw("null");
  }
  out.raw(",\"faces\":[");
  for (std::size_t k = 0; k < faces.count; ++k) {
    if (k > 0) out.raw(',');
    write_face(out, faces.face[k]);
  }
  out.raw("],\"normal\":");
  if (faces.count == 0) return out.raw("null");
  const Vec3d& normal = answers.normal[i];
  out.vector(normal.x, normal.y, normal.z);
}

void write_miss(JsonWriter& out, const RayBoxAnswers& answers, std::size_t i) {
  out.raw("\"hit\":false,\"miss\":");
  const RayBoxOutcome outcome = answers.outcome[i];
  if (outcome == RayBoxOutcome::kBehind || outcome == RayBoxOutcome::kBeyond) {
    out.raw(outcome == RayBoxOutcome::kBehind ? "\"behind\"" : "\"beyond\"");
    return write_span(out, answers, i);
  }
  const auto& [a, b] = answers.apart[i];
  out.raw("[\"");
  out.raw("xyz"[a]);
  if (a != b) {
    out.raw("\",\"");
    out.raw("xyz"[b]);
  }
  out.raw("\"]");
}

}  // namespace

Result<RayBoxQuery> decode_ray_boxes(std::string& body, const RayBoxJsonRules& rules) {
  return RayBoxReader(rules).read_all(body);
}

std::string encode_ray_boxes(const RayBoxAnswers& answers) {
  JsonWriter out(32 + answers.size() * 160);
  out.raw("{\"results\":[");
  for (std::size_t i = 0; i < answers.size(); ++i) {
    out.raw(i > 0 ? ",{" : "{");
    if (answers.outcome[i] == RayBoxOutcome::kHit) {
      write_hit(out, answers, i);
    } else {
      write_miss(out, answers, i);
    }
    if (!answers.planes.empty()) {
      out.raw(",\"planes\":[");
      for (std::size_t k = 0; k < 6; ++k) {
        if (k > 0) out.raw(',');
        out.number(answers.planes[i][k].value_or(kInf));
      }
      out.raw(']');
    }
    out.raw('}');
  }
  out.raw("]}");
  return out.take();
}

}  // namespace sightline
