#pragma once
/// Rays as lines of JSON (application/x-ndjson), a batch of them at a time.
///
///   {"options":{"fields":["t"],"cull":"back"}}          may stand first, once
///   {"origin":[x,y,z],"direction":[x,y,z],"tmax":10}    one ray; lines without any text count not
///
/// The options are those of a JSON request without the rays.

#include <memory>
#include <string>
#include <string_view>

#include "proto/json/ray_json.h"

namespace sightline {

class RayLines {
 public:
  explicit RayLines(const RayJsonRules& rules);
  ~RayLines();

  /// The rays of these lines, of which the last may lack its end. `text` is only read; its capacity
  /// grows as decode_rays says. Places are /rays/N with N counted from the first line of all.
  /// Errors: those of decode_rays, and 400 JSON_MALFORMED for a line that is not one object.
  Result<RayQuery> decode(std::string& text);

 private:
  class Reader;
  RayJsonRules rules_;
  RayQuery options_;
  std::unique_ptr<Reader> reader_;
  std::size_t seen_ = 0;  ///< rays so far
  bool begun_ = false;
};

}  // namespace sightline
