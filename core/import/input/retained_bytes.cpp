#include "core/import/input/retained_bytes.h"

#include <algorithm>
#include <cstring>

#include "core/base/pages.h"

namespace sightline::gltf {

FileParts merged(FileParts parts) {
  std::sort(parts.begin(), parts.end());
  FileParts apart;
  for (const auto& [begin, length] : parts) {
    if (!apart.empty() && begin <= apart.back().first + apart.back().second) {
      const std::uint64_t end = std::max(apart.back().first + apart.back().second, begin + length);
      apart.back().second = end - apart.back().first;
    } else {
      apart.emplace_back(begin, length);
    }
  }
  return apart;
}

std::uint64_t bytes_of(const FileParts& parts) {
  std::uint64_t sum = 0;
  for (const auto& [begin, length] : parts) sum += length;
  return sum;
}

RetainedBytes::RetainedBytes(std::span<const std::byte> whole, const FileParts& parts)
    : pages_(static_cast<std::byte*>(take_pages(std::max<std::size_t>(whole.size(), 1)))),
      size_(whole.size()) {
  for (const auto& [begin, length] : parts) {
    std::memcpy(pages_ + begin, whole.data() + begin, length);
  }
}

RetainedBytes::~RetainedBytes() { give_pages(pages_, std::max<std::size_t>(size_, 1)); }

}  // namespace sightline::gltf
