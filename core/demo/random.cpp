#include "core/demo/random.h"

#include <cmath>

namespace sightline::demo {

double Random::spread(double low, double high) {
  // Draw how often the range is halved, then uniformly within that halving.
  int octaves = 0;
  for (double size = high; size > low && octaves < 64; size *= 0.5) ++octaves;
  double top = high;
  for (std::uint32_t i = below(static_cast<std::uint32_t>(octaves > 0 ? octaves : 1)); i > 0; --i) {
    top *= 0.5;
  }
  const double bottom = top * 0.5 > low ? top * 0.5 : low;
  return between(bottom, top);
}

namespace {

/// In [-1, 1): the value of a lattice point.
double lattice(std::int64_t x, std::int64_t z, std::uint64_t seed) {
  const std::uint64_t key = scramble(scramble(static_cast<std::uint64_t>(x) ^ seed) ^
                                     static_cast<std::uint64_t>(z) * 0xd6e8feb86659fd93u);
  return static_cast<double>(key >> 11) * 0x1p-52 - 1.0;
}

/// [Perlin2002]: the quintic whose first and second derivatives vanish at 0 and 1.
double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

double value_noise(double x, double z, std::uint64_t seed) {
  const double fx = std::floor(x), fz = std::floor(z);
  const auto ix = static_cast<std::int64_t>(fx), iz = static_cast<std::int64_t>(fz);
  const double u = fade(x - fx), v = fade(z - fz);
  const double a = lattice(ix, iz, seed), b = lattice(ix + 1, iz, seed);
  const double c = lattice(ix, iz + 1, seed), d = lattice(ix + 1, iz + 1, seed);
  const double near = a + (b - a) * u, far = c + (d - c) * u;
  return near + (far - near) * v;
}

}  // namespace

double fractal_noise(double x, double z, double cell, int octaves, std::uint64_t seed) {
  double sum = 0, weight = 0.5, scale = 1 / cell;
  for (int i = 0; i < octaves; ++i) {
    sum += weight * value_noise(x * scale, z * scale, scramble(seed + static_cast<unsigned>(i)));
    weight *= 0.5;
    scale *= 2;
  }
  return sum;
}

Affine random_turn(Random& random) {
  // tan(a/2) in [-1, 1) covers half a turn; the sign covers the other half.
  const double t = random.between(-1, 1);
  const double sign = (random.bits() & 1) != 0 ? 1 : -1;
  const double c = sign * ((1 - t * t) / (1 + t * t)), s = sign * (2 * t / (1 + t * t));
  Affine r;
  r.m[0][0] = c;
  r.m[0][2] = s;
  r.m[2][0] = -s;
  r.m[2][2] = c;
  return r;
}

Affine random_rotation(Random& random) {
  // A quaternion drawn from the shell between two balls; dividing by its squared length makes the
  // matrix a rotation without a square root.
  double x = 0, y = 0, z = 0, w = 0, n = 0;
  do {
    x = random.between(-1, 1);
    y = random.between(-1, 1);
    z = random.between(-1, 1);
    w = random.between(-1, 1);
    n = x * x + y * y + z * z + w * w;
  } while (n < 0.1 || n > 1);
  const double s = 2 / n;
  Affine r;
  r.m[0][0] = 1 - s * (y * y + z * z);
  r.m[0][1] = s * (x * y - z * w);
  r.m[0][2] = s * (x * z + y * w);
  r.m[1][0] = s * (x * y + z * w);
  r.m[1][1] = 1 - s * (x * x + z * z);
  r.m[1][2] = s * (y * z - x * w);
  r.m[2][0] = s * (x * z - y * w);
  r.m[2][1] = s * (y * z + x * w);
  r.m[2][2] = 1 - s * (x * x + y * y);
  return r;
}

Affine translation(double x, double y, double z) {
  Affine r;
  r.m[0][3] = x;
  r.m[1][3] = y;
  r.m[2][3] = z;
  return r;
}

Affine scaling(double x, double y, double z) {
  Affine r;
  r.m[0][0] = x;
  r.m[1][1] = y;
  r.m[2][2] = z;
  return r;
}

}  // namespace sightline::demo
