#include "proto/json/ray_columns.h"

#include <bit>
#include <cstring>

#include "proto/json/json_writer.h"

namespace sightline {

std::string encode_ray_columns(const RayBatch& rays) {
  JsonWriter out(64 + rays.size() * 130);
  const auto vectors = [&](std::string_view name, const UnsetColumn<double>& x,
                           const UnsetColumn<double>& y, const UnsetColumn<double>& z) {
    out.raw(name);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (i > 0) out.raw(',');
      out.number(x[i]);
      out.raw(',');
      out.number(y[i]);
      out.raw(',');
      out.number(z[i]);
    }
  };
  const auto numbers = [&](std::string_view name, const UnsetColumn<double>& column) {
    out.raw(name);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (i > 0) out.raw(',');
      out.number(column[i]);
    }
  };
  vectors("{\"origins\":[", rays.ox, rays.oy, rays.oz);
  vectors("],\"directions\":[", rays.dx, rays.dy, rays.dz);
  numbers("],\"tmin\":[", rays.tmin);
  numbers("],\"tmax\":[", rays.tmax);
  out.raw("]}");
  return out.take();
}

std::string encode_rays_binary(const RayBatch& rays) {
  static_assert(std::endian::native == std::endian::little, "columns are copied as they stand");
  // The header of docs/reference/binary.md: float64, with tmin and tmax, without options.
  constexpr std::size_t kHeaderBytes = 24;
  constexpr std::uint32_t kFlags = 7;
  const std::uint64_t count = rays.size();
  std::string out(kHeaderBytes, '\0');
  std::memcpy(out.data(), "SLR1", 4);
  std::memcpy(out.data() + 4, &kFlags, 4);
  std::memcpy(out.data() + 8, &count, 8);
  out.reserve(kHeaderBytes + rays.size() * 8 * sizeof(double));
  for (const UnsetColumn<double>* column :
       {&rays.ox, &rays.oy, &rays.oz, &rays.dx, &rays.dy, &rays.dz, &rays.tmin, &rays.tmax}) {
    out.append(reinterpret_cast<const char*>(column->data()), column->size() * sizeof(double));
  }
  return out;
}

}  // namespace sightline
