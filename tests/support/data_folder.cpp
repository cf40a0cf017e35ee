#include "tests/support/data_folder.h"

#include <cstdlib>
#include <fstream>

namespace sightline::test {

std::filesystem::path source_folder() {
  const char* named = std::getenv("SIGHTLINE_SOURCE");
  return named != nullptr && *named != '\0' ? named : SIGHTLINE_SOURCE_FOLDER;
}

std::optional<std::filesystem::path> data_folder() {
  const char* named = std::getenv("SIGHTLINE_DATA");
  const std::filesystem::path folder = named != nullptr && *named != '\0'
                                           ? std::filesystem::path(named)
                                           : source_folder() / ".." / "shared" / "data";
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) return std::nullopt;
  return folder;
}

std::filesystem::path test_data(const std::filesystem::path& relative) {
  return source_folder() / "tests" / "data" / relative;
}

std::vector<std::byte> read_bytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) return {};
  std::vector<std::byte> bytes(static_cast<std::size_t>(in.tellg()));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in) bytes.clear();
  return bytes;
}

}  // namespace sightline::test
