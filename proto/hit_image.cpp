#include "proto/hit_image.h"

#include <png.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/query/ray_generators.h"

namespace sightline {
namespace {

constexpr double kWhite = 65535;

std::uint16_t sample(double value, double least) {
  return static_cast<std::uint16_t>(std::clamp(std::nearbyint(value), least, kWhite));
}

Error too_many_nodes(std::uint32_t node) {
  return {
      ErrorKind::kInvalid, "IMAGE_NODES_TOO_MANY",
      "node " + std::to_string(node) + " does not fit 16 bits: ask for image/x-portable-floatmap",
      "/image"};
}

std::uint64_t numbers_of(const HitImage& image) {
  return image.of == HitImage::Of::kNormal || image.of == HitImage::Of::kNodeColours ||
                 image.of == HitImage::Of::kShaded
             ? 3
             : 1;
}

Result<std::string> encode_png(const HitImage& image, const std::vector<std::uint16_t>& samples) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = numbers_of(image) == 3 ? PNG_FORMAT_LINEAR_RGB : PNG_FORMAT_LINEAR_Y;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, samples.data(), 0, nullptr) == 0) {
    return Error{ErrorKind::kInternal, "IMAGE_FAILED", "the image could not be encoded", ""};
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace

Status HitImageEncoder::check(const HitImage& image) {
  constexpr std::uint64_t kMostSide = 1'000'000;  // libpng's
  if (image.width <= kMostSide && image.height <= kMostSide) return success();
  return Error{ErrorKind::kInvalid, "IMAGE_TOO_LARGE",
               "an image has at most 1000000 pixels to a side", "/generator"};
}

std::uint64_t HitImageEncoder::bytes(const HitImage& image) {
  constexpr std::uint64_t kHead = 1024, kRow = 16;  // libpng's and more
  const std::uint64_t numbers = image.width * image.height * numbers_of(image);
  return kHead + image.height * kRow + numbers * (image.floats ? sizeof(float) : 6);
}

HitImageEncoder::HitImageEncoder(const HitImage& image) : image_(image), width_(numbers_of(image)) {
  const std::size_t numbers = image.width * image.height * width_;
  if (!image.floats) {
    samples_.assign(numbers, 0);
    return;
  }
  floats_ = (width_ == 3 ? "PF\n" : "Pf\n") + std::to_string(image.width) + " " +
            std::to_string(image.height) + "\n-1.0\n";
  head_ = floats_.size();
  floats_.resize(head_ + numbers * sizeof(float));
}

Status HitImageEncoder::draw(std::uint64_t begin, std::uint64_t end, const HitPixels& pixels) {
  if (!image_.floats) return draw_samples(begin, end, pixels);
  draw_floats(begin, end, pixels);
  return success();
}

Status HitImageEncoder::draw_samples(std::uint64_t begin, std::uint64_t end,
                                     const HitPixels& pixels) {
  Status status = success();
  std::size_t i = 0;
  for_each_pixel(image_.width, begin, end, [&](std::uint64_t row, std::uint64_t column) {
    const std::size_t from = i++;
    std::uint16_t* const to = &samples_[(row * image_.width + column) * width_];
    if (image_.of == HitImage::Of::kVisits) *to = sample(pixels.visits[from], 0);
    if (!pixels.hits.hit(from)) return;
    switch (image_.of) {
      case HitImage::Of::kDepth:
        *to = sample(pixels.depth[from] / image_.unit, 1);
        break;
      case HitImage::Of::kNode:
        if (pixels.node[from] >= kWhite) {
          status = too_many_nodes(pixels.node[from]);
        } else {
          *to = static_cast<std::uint16_t>(pixels.node[from] + 1);
        }
        break;
      case HitImage::Of::kNormal:
        for (int k = 0; k < 3; ++k) to[k] = sample(kWhite * (pixels.normal[from][k] + 1) / 2, 0);
        break;
      case HitImage::Of::kNodeColours:
      case HitImage::Of::kShaded:
        for (int k = 0; k < 3; ++k) to[k] = sample(kWhite * pixels.colour[from][k], 0);
        break;
      case HitImage::Of::kVisits:
        break;
    }
  });
  return status;
}

void HitImageEncoder::draw_floats(std::uint64_t begin, std::uint64_t end, const HitPixels& pixels) {
  static_assert(std::endian::native == std::endian::little);
  char* const first = floats_.data() + head_;
  std::size_t i = 0;
  for_each_pixel(image_.width, begin, end, [&](std::uint64_t row, std::uint64_t column) {
    const std::size_t from = i++;
    const bool hit = pixels.hits.hit(from);
    float numbers[3] = {};
    switch (image_.of) {
      case HitImage::Of::kDepth:
        numbers[0] =
            static_cast<float>(hit ? pixels.depth[from] : std::numeric_limits<double>::infinity());
        break;
      case HitImage::Of::kNode:
        numbers[0] = hit ? static_cast<float>(pixels.node[from]) : -1.0f;
        break;
      case HitImage::Of::kNormal:
        for (int k = 0; k < 3; ++k) {
          numbers[k] = hit ? static_cast<float>(pixels.normal[from][k]) : 0.0f;
        }
        break;
      case HitImage::Of::kNodeColours:
      case HitImage::Of::kShaded:
        for (int k = 0; k < 3; ++k) {
          numbers[k] = hit ? static_cast<float>(pixels.colour[from][k]) : 0.0f;
        }
        break;
      case HitImage::Of::kVisits:
        numbers[0] = static_cast<float>(pixels.visits[from]);
        break;
    }
    const std::size_t bytes = width_ * sizeof(float);
    std::memcpy(first + ((image_.height - 1 - row) * image_.width + column) * bytes, numbers,
                bytes);
  });
}

Result<std::string> HitImageEncoder::finish() {
  return image_.floats ? std::move(floats_) : encode_png(image_, samples_);
}

}  // namespace sightline
