#include "proto/hit_image.h"

#include <png.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

namespace sightline {
namespace {

constexpr double kWhite = 65535;

std::uint16_t sample(double value, double least) {
  return static_cast<std::uint16_t>(std::clamp(std::nearbyint(value), least, kWhite));
}

double depth_of(const HitBatch& hits, const HitTerms& terms, std::size_t i) {
  return terms.t_is_distance ? terms.distance[i] : hits.t[i];
}

std::size_t samples_of(const HitImage& image) { return image.of == HitImage::Of::kNormal ? 3 : 1; }

Result<std::vector<std::uint16_t>> png_samples(const HitImage& image, const HitBatch& hits,
                                               std::span<const HitDetail> details,
                                               const HitTerms& terms) {
  const std::size_t width = samples_of(image);
  std::vector<std::uint16_t> samples(hits.size() * width, 0);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (image.of == HitImage::Of::kVisits) samples[i] = sample(terms.visits[i], 0);
    if (!hits.hit(i)) continue;
    switch (image.of) {
      case HitImage::Of::kDepth:
        samples[i] = sample(depth_of(hits, terms, i) / image.unit, 1);
        break;
      case HitImage::Of::kNode:
        if (terms.node[i] >= 65535) {
          return Error{ErrorKind::kInvalid, "IMAGE_NODES_TOO_MANY",
                       "node " + std::to_string(terms.node[i]) +
                           " does not fit 16 bits: ask for image/x-portable-floatmap",
                       "/image"};
        }
        samples[i] = static_cast<std::uint16_t>(terms.node[i] + 1);
        break;
      case HitImage::Of::kNormal:
        for (int k = 0; k < 3; ++k) {
          samples[i * 3 + static_cast<std::size_t>(k)] =
              sample(kWhite * (details[i].normal[k] + 1) / 2, 0);
        }
        break;
      case HitImage::Of::kVisits:
        break;
    }
  }
  return samples;
}

Result<std::string> encode_png(const HitImage& image, const std::vector<std::uint16_t>& samples) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = image.of == HitImage::Of::kNormal ? PNG_FORMAT_LINEAR_RGB : PNG_FORMAT_LINEAR_Y;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, samples.data(), 0, nullptr) == 0) {
    return Error{ErrorKind::kInternal, "IMAGE_FAILED", "the image could not be encoded", ""};
  }
  bytes.resize(size);
  return bytes;
}

std::string encode_floats(const HitImage& image, const HitBatch& hits,
                          std::span<const HitDetail> details, const HitTerms& terms) {
  static_assert(std::endian::native == std::endian::little);
  const std::size_t width = samples_of(image), row = image.width * width;
  std::string bytes = (width == 3 ? "PF\n" : "Pf\n") + std::to_string(image.width) + " " +
                      std::to_string(image.height) + "\n-1.0\n";
  const std::size_t head = bytes.size();
  bytes.resize(head + hits.size() * width * sizeof(float));
  const auto put = [&](std::size_t i, std::size_t k, double value) {
    const std::size_t from_below = image.height - 1 - i / image.width;
    const auto number = static_cast<float>(value);
    const std::size_t at = from_below * row + i % image.width * width + k;
    std::copy_n(reinterpret_cast<const char*>(&number), sizeof number,
                bytes.data() + head + at * sizeof number);
  };
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const bool hit = hits.hit(i);
    switch (image.of) {
      case HitImage::Of::kDepth:
        put(i, 0, hit ? depth_of(hits, terms, i) : std::numeric_limits<double>::infinity());
        break;
      case HitImage::Of::kNode:
        put(i, 0, hit ? static_cast<double>(terms.node[i]) : -1);
        break;
      case HitImage::Of::kNormal:
        for (int k = 0; k < 3; ++k) {
          put(i, static_cast<std::size_t>(k), hit ? details[i].normal[k] : 0);
        }
        break;
      case HitImage::Of::kVisits:
        put(i, 0, terms.visits[i]);
        break;
    }
  }
  return bytes;
}

}  // namespace

Result<std::string> encode_image(const HitImage& image, const HitBatch& hits,
                                 std::span<const HitDetail> details, const HitTerms& terms) {
  constexpr std::uint64_t kMostSide = 1'000'000;  // libpng's
  if (image.width > kMostSide || image.height > kMostSide) {
    return Error{ErrorKind::kInvalid, "IMAGE_TOO_LARGE",
                 "an image has at most 1000000 pixels to a side", "/generator"};
  }
  if (image.floats) return encode_floats(image, hits, details, terms);
  const auto samples = png_samples(image, hits, details, terms);
  return samples ? encode_png(image, *samples) : Result<std::string>(samples.error());
}

}  // namespace sightline
