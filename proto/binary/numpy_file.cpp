#include "proto/binary/numpy_file.h"

#include <zlib.h>

#include <utility>

namespace sightline {
namespace {

/// Version 2.0, no flags, stored, 1980-01-01.
std::string common_head() { return std::string("\x14\0\0\0\0\0\0\0\x21\0", 10); }

}  // namespace

std::string npy_head(const std::string& type, const std::string& shape) {
  std::string text = "{'descr': " + type + ", 'fortran_order': False, 'shape': (" + shape + "), }";
  constexpr std::size_t kBefore = 10;
  text.append(63 - (kBefore + text.size()) % 64, ' ').append("\n");
  std::string head("\x93NUMPY\x01\x00", 8);
  append_number(head, static_cast<std::uint16_t>(text.size()));
  return head + text;
}

void ZipArchive::add(const std::string& name, const std::string& bytes) {
  std::string sizes;
  append_number(sizes, static_cast<std::uint32_t>(
                           crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size())));
  append_number(sizes, static_cast<std::uint32_t>(bytes.size()));
  append_number(sizes, static_cast<std::uint32_t>(bytes.size()));
  append_number(sizes, static_cast<std::uint16_t>(name.size()));
  const auto at = static_cast<std::uint32_t>(out_.size());
  const std::string common = common_head() + sizes;
  out_ += "PK\3\4" + common + std::string(2, '\0') + name + bytes;
  // An entry of the directory repeats the head, without extra field, comment, disk and attributes,
  // and ends with the place of the file.
  directory_ += "PK\1\2" + std::string("\x14\0", 2) + common + std::string(12, '\0');
  append_number(directory_, at);
  directory_ += name;
  ++files_;
}

std::string ZipArchive::take() {
  const auto at = static_cast<std::uint32_t>(out_.size());
  out_ += directory_ + "PK\5\6" + std::string(4, '\0');
  append_number(out_, files_);
  append_number(out_, files_);
  append_number(out_, static_cast<std::uint32_t>(directory_.size()));
  append_number(out_, at);
  return std::move(out_) + std::string(2, '\0');
}

}  // namespace sightline
