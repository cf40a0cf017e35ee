#pragma once
/// Points as JSON, and whether they lie inside.
///
///   {"points":[[x,y,z],...],"method":"parity"}
///
/// "method": "parity" or "winding"; "include", "exclude" and "work" as for rays.

#include <string>

#include "core/base/column.h"
#include "proto/ray_json.h"

namespace sightline {

struct InsideQuery {
  Column<Vec3d> points;
  bool by_winding = false;
  RayQuery options;  ///< without rays
};

/// `body` as decode_rays takes it. Errors: as decode_rays, and 413 POINTS_TOO_MANY.
Result<InsideQuery> decode_inside(std::string& body, std::size_t max_points);

/// {"method":"parity","inside":[true,null],"on_surface":[false,true],"reliable":[true,true]}, with
/// "winding":[1,0] for that method. On the surface "inside" is null.
std::string encode_inside(const InsideQuery& query, std::span<const std::uint8_t> inside,
                          std::span<const std::uint8_t> on_surface,
                          std::span<const std::uint8_t> reliable,
                          std::span<const std::int64_t> winding);

}  // namespace sightline
