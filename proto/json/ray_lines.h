#pragma once
/// RayLines: decodes rays from lines of JSON (application/x-ndjson), some lines at a time.
///
///   {"options":{"fields":["t"],"cull":"back"}}          may be the first line
///   {"origin":[x,y,z],"direction":[x,y,z],"tmax":10}    a ray; blank lines are ignored
///
/// The options are those of a JSON request, without the rays.

#include <memory>
#include <string>
#include <string_view>

#include "proto/json/ray_json.h"

namespace sightline {

/// Decodes the lines of one stream in order: decode() for some lines at a time. Not thread-safe.
class RayLines {
 public:
  explicit RayLines(const RayJsonRules& rules);
  ~RayLines();

  /// Decodes the rays of the next lines, which are whole; the last line may lack its end of line.
  /// The capacity of `text` grows as in decode_rays. Pointers are /rays/N, where N counts the rays
  /// of the whole stream. Errors: those of decode_rays, and 400 JSON_MALFORMED for a line that is
  /// not one object. No call may follow an error.
  Result<RayQuery> decode(std::string& text);

 private:
  class Reader;
  RayJsonRules rules_;
  RayQuery options_;
  std::unique_ptr<Reader> reader_;
  std::size_t seen_ = 0;  ///< number of rays so far
  bool begun_ = false;
};

}  // namespace sightline
