#include "proto/plain_rays.h"

#include <algorithm>
#include <cstring>
#include <initializer_list>
#include <string_view>

#include "proto/plain_number.h"

namespace sightline {
namespace {

/// Of columns that are written one by one, and grow by doubling.
constexpr std::size_t kFirstRoom = 64;

void skip_blanks(const char*& at) {
  while (*at == ' ' || *at == '\n' || *at == '\r' || *at == '\t') ++at;
}

/// A sign of JSON and the blanks around it.
bool take(const char*& at, char sign) {
  skip_blanks(at);
  if (*at != sign) return false;
  ++at;
  skip_blanks(at);
  return true;
}

bool take_word(const char*& at, std::string_view word) {
  if (std::memcmp(at, word.data(), word.size()) != 0) return false;
  at += word.size();
  return true;
}

bool scan_vector(const char*& at, Vec3d& vector) {
  return take(at, '[') && scan_plain_number(at, vector.x) && take(at, ',') &&
         scan_plain_number(at, vector.y) && take(at, ',') && scan_plain_number(at, vector.z) &&
         take(at, ']');
}

void write_ray(RayBatch& rays, std::size_t i, const Ray& ray) {
  rays.ox[i] = ray.origin.x;
  rays.oy[i] = ray.origin.y;
  rays.oz[i] = ray.origin.z;
  rays.dx[i] = ray.direction.x;
  rays.dy[i] = ray.direction.y;
  rays.dz[i] = ray.direction.z;
  rays.tmin[i] = ray.tmin;
  rays.tmax[i] = ray.tmax;
}

}  // namespace

bool scan_plain_ray(const char*& at, Ray& ray) {
  constexpr unsigned kOrigin = 1, kDirection = 2, kTmin = 4, kTmax = 8;
  constexpr std::string_view kOriginKey = "\"origin\"", kDirectionKey = "\"direction\"",
                             kTminKey = "\"tmin\"", kTmaxKey = "\"tmax\"", kNull = "null";
  static_assert(kDirectionKey.size() <= kPlainPadding);
  unsigned seen = 0;
  if (!take(at, '{')) return false;
  do {
    const unsigned part = take_word(at, kOriginKey)      ? kOrigin
                          : take_word(at, kDirectionKey) ? kDirection
                          : take_word(at, kTmaxKey)      ? kTmax
                          : take_word(at, kTminKey)      ? kTmin
                                                         : 0;
    if (part == 0 || (seen & part) != 0 || !take(at, ':')) return false;
    seen |= part;
    const bool good = part == kOrigin      ? scan_vector(at, ray.origin)
                      : part == kDirection ? scan_vector(at, ray.direction)
                      : part == kTmin      ? scan_plain_number(at, ray.tmin)
                                      : take_word(at, kNull) || scan_plain_number(at, ray.tmax);
    if (!good) return false;
  } while (take(at, ','));
  return (seen & (kOrigin | kDirection)) == (kOrigin | kDirection) && *at++ == '}';
}

bool scan_plain_rays(const char*& at, std::size_t most, double default_tmin, RayBatch& rays) {
  if (!take(at, '[')) return false;
  std::size_t count = 0;
  do {
    Ray ray;
    ray.tmin = default_tmin;
    if (count == most || !scan_plain_ray(at, ray)) return false;
    if (count == rays.size()) rays.resize(std::max(kFirstRoom, 2 * count));
    write_ray(rays, count++, ray);
  } while (take(at, ','));
  rays.resize(count);
  return *at == ']' && ++at;
}

bool scan_plain_vectors(const char*& at, std::size_t most, Column<double>& x, Column<double>& y,
                        Column<double>& z) {
  if (!take(at, '[')) return false;
  std::size_t count = 0;
  const auto resize = [&](std::size_t room) {
    for (Column<double>* column : {&x, &y, &z}) column->resize(room);
  };
  do {
    if (count == x.size()) resize(std::max(kFirstRoom, 2 * count));
    if (count == most || !scan_plain_number(at, x[count]) || !take(at, ',') ||
        !scan_plain_number(at, y[count]) || !take(at, ',') || !scan_plain_number(at, z[count])) {
      return false;
    }
    ++count;
  } while (take(at, ','));
  resize(count);
  return *at == ']' && ++at;
}

}  // namespace sightline
