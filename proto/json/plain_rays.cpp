#include "proto/json/plain_rays.h"

#include <algorithm>
#include <cstring>
#include <initializer_list>
#include <string_view>

#include "proto/json/plain_number.h"

namespace sightline {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

const char* behind_blanks(const char* at) {
  while (is_blank(*at)) ++at;
  return at;
}

/// A sign of JSON and the blanks around it.
[[gnu::always_inline]] inline bool take(const char*& at, char sign) {
  if (static_cast<unsigned char>(*at) <= ' ') at = behind_blanks(at);
  if (*at != sign) return false;
  ++at;
  if (static_cast<unsigned char>(*at) <= ' ') at = behind_blanks(at);
  return true;
}

bool take_word(const char*& at, std::string_view word) {
  if (std::memcmp(at, word.data(), word.size()) != 0) return false;
  at += word.size();
  return true;
}

[[gnu::always_inline]] inline bool scan_three(const char*& at, double (&out)[3]) {
  for (int k = 0; k < 3; ++k) {
    if ((k > 0 && !take(at, ',')) || !scan_plain_number(at, out[k])) return false;
  }
  return true;
}

bool scan_vector(const char*& place, Vec3d& vector) {
  const char* at = place;  // a local one stays in a register
  double numbers[3];
  if (!take(at, '[') || !scan_three(at, numbers) || !take(at, ']')) return false;
  place = at;
  vector = {numbers[0], numbers[1], numbers[2]};
  return true;
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

namespace {

/// The room that columns need, when `count` rows were read from `begin` to `at` of a text that ends
/// at `end`. They are written row by row, and growth by doubling would take twice the memory.
std::size_t room_for(std::size_t count, const char* begin, const char* at, const char* end) {
  constexpr std::size_t kFirst = 16;
  if (count < kFirst) return kFirst;
  const double rows_per_byte = static_cast<double>(count) / static_cast<double>(at - begin);
  const auto rest = static_cast<std::size_t>(rows_per_byte * static_cast<double>(end - at));
  return count + rest + count / 16 + 1;
}

bool scan_rays(const char*& at, const char* end, std::size_t most, double default_tmin,
               RayBatch& rays) {
  const char* const begin = at;
  if (!take(at, '[')) return false;
  std::size_t count = 0;
  do {
    Ray ray;
    ray.tmin = default_tmin;
    if (count == most || !scan_plain_ray(at, ray)) return false;
    if (count == rays.size()) rays.resize(std::min(most, room_for(count, begin, at, end)));
    rays.set(count++, ray);
  } while (take(at, ','));
  rays.resize(count);
  return *at++ == ']';
}

bool scan_vectors(const char*& place, const char* end, std::size_t most, UnsetColumn<double>& x,
                  UnsetColumn<double>& y, UnsetColumn<double>& z) {
  const char* const begin = place;
  const char* at = begin;
  if (!take(at, '[')) return false;
  std::size_t count = 0;
  const auto resize = [&](std::size_t room) {
    for (UnsetColumn<double>* column : {&x, &y, &z}) column->resize(room);
  };
  do {
    if (count == most) return false;
    if (count == x.size()) resize(std::min(most, room_for(count, begin, at, end)));
    double numbers[3];
    if (!scan_three(at, numbers)) return false;
    x[count] = numbers[0];
    y[count] = numbers[1];
    z[count] = numbers[2];
    ++count;
  } while (take(at, ','));
  resize(count);
  place = at + 1;
  return *at == ']';
}

/// Moves `at` behind the string that begins there.
bool skip_string(const char*& at, const char* end) {
  if (*at != '"') return false;
  for (++at; at < end; ++at) {
    if (*at == '\\') {
      ++at;
    } else if (*at == '"') {
      ++at;
      return true;
    }
  }
  return false;
}

/// Skips any value, up to the comma or bracket behind it, without checking it closely.
bool skip_value(const char*& at, const char* end) {
  std::size_t depth = 0;
  while (at < end) {
    if (*at == '"') {
      if (!skip_string(at, end)) return false;
      continue;
    }
    if (depth == 0 && (*at == ',' || *at == '}')) return true;
    if (*at == '[' || *at == '{') ++depth;
    if (*at == ']' || *at == '}') --depth;
    ++at;
  }
  return false;
}

}  // namespace

bool take_plain_arrays(std::string_view body, std::size_t most, double default_tmin,
                       PlainArrays& arrays) {
  constexpr std::string_view kEmpty = "[]";
  RayBatch& rays = arrays.rays;
  const char *at = body.data(), *const end = at + body.size();
  const char* kept = at;  // what follows is not in `rest` yet
  if (!take(at, '{')) return false;
  do {
    const char* const key = at;
    if (!skip_string(at, end)) return false;
    const std::string_view name(key, static_cast<std::size_t>(at - key));
    if (!take(at, ':')) return false;
    const char* const value = at;
    bool* const has = name == "\"rays\""         ? &arrays.has_rays
                      : name == "\"origins\""    ? &arrays.has_origins
                      : name == "\"directions\"" ? &arrays.has_directions
                                                 : nullptr;
    if (has == nullptr) {
      if (!skip_value(at, end)) return false;
      continue;
    }
    // Twice, or rows and columns in one body: the other reader knows what to say.
    const bool is_rows = has == &arrays.has_rays;
    if (*has || (is_rows ? arrays.has_origins || arrays.has_directions : arrays.has_rays)) {
      return false;
    }
    *has = true;
    const bool good = is_rows ? scan_rays(at, end, most, default_tmin, rays)
                      : has == &arrays.has_origins
                          ? scan_vectors(at, end, most, rays.ox, rays.oy, rays.oz)
                          : scan_vectors(at, end, most, rays.dx, rays.dy, rays.dz);
    if (!good || at > end) return false;
    arrays.rest.append(kept, value).append(kEmpty);
    kept = at;
  } while (take(at, ','));
  if (kept == body.data()) return false;
  // The parser takes four bytes for each byte of its text.
  const char* last = end;
  while (last > kept && is_blank(last[-1])) --last;
  arrays.rest.append(kept, last);
  return true;
}

}  // namespace sightline
