#include "proto/json/json_writer.h"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "proto/json/number_text.h"

namespace sightline {
namespace {

bool needs_no_escape(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x20 && byte < 0x80 && c != '"' && c != '\\';
  });
}

}  // namespace

JsonWriter::JsonWriter(std::size_t expected_bytes) {
  buffer_.reserve(std::max<std::size_t>(expected_bytes, 256));
}

void JsonWriter::grow(std::size_t bytes) {
  // Step by step: to resize is to touch, and what was reserved in vain must not become memory.
  constexpr std::size_t kStep = 64 << 10;
  if (bytes > buffer_.capacity()) buffer_.reserve(std::max(buffer_.capacity() * 2, bytes));
  buffer_.resize(std::min(buffer_.capacity(), bytes + kStep));
}

void JsonWriter::number(double value) { written_to(write_json_number(room(kNumberRoom), value)); }

void JsonWriter::number(std::uint64_t value) {
  written_to(write_integer(room(kNumberRoom), value));
}

void JsonWriter::vector(double x, double y, double z) {
  raw('[');
  number(x);
  raw(',');
  number(y);
  raw(',');
  number(z);
  raw(']');
}

void JsonWriter::string(std::string_view text) {
  if (!needs_no_escape(text)) {
    return raw(nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }
  char* begin = room(text.size() + 2);
  begin[0] = '"';
  std::memcpy(begin + 1, text.data(), text.size());
  begin[text.size() + 1] = '"';
  size_ += text.size() + 2;
}

std::string JsonWriter::take() {
  buffer_.resize(size_);
  size_ = 0;
  return std::move(buffer_);
}

}  // namespace sightline
