#include "proto/binary/binary_answer.h"

#include <algorithm>
#include <bit>

namespace sightline {

static_assert(std::endian::native == std::endian::little, "columns are copied as they stand");

void BinaryAnswer::begin() {
  constexpr std::size_t kHeaderBytes = 16, kEntryBytes = 40, kNameBytes = 16;
  const std::size_t table = kHeaderBytes + entries_.size() * kEntryBytes;
  size_ = table;
  for (Entry& entry : entries_) {
    entry.at = size_;
    size_ += (entry.bytes() + 7) / 8 * 8;
  }
  text_.reserve(size_);
  text_.assign(table, '\0');
  std::memcpy(text_.data(), "SLA1", 4);
  write(4, static_cast<std::uint32_t>(entries_.size()));
  std::size_t at = kHeaderBytes;
  for (const Entry& entry : entries_) {
    std::memcpy(text_.data() + at, entry.name.data(), std::min(entry.name.size(), kNameBytes));
    write(at + 16, entry.type);
    write(at + 20, entry.width);
    write(at + 24, std::uint64_t{entry.at});
    write(at + 32, std::uint64_t{entry.rows});
    at += kEntryBytes;
  }
}

std::string BinaryAnswer::take() {
  text_.resize(size_);
  return std::move(text_);
}

}  // namespace sightline
