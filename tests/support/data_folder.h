#pragma once
/// Where tests find their files.

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace sightline::test {

/// The root of the source tree: $SIGHTLINE_SOURCE, else where this file was compiled.
std::filesystem::path source_folder();

/// The shared data folder: $SIGHTLINE_DATA, else <source>/../shared/data; nothing when absent.
/// Tests that need it GTEST_SKIP() with the reason.
std::optional<std::filesystem::path> data_folder();

/// A file or folder under tests/data, which is part of the source tree.
std::filesystem::path test_data(const std::filesystem::path& relative);

/// The whole file; empty when it cannot be read.
std::vector<std::byte> read_bytes(const std::filesystem::path& file);

}  // namespace sightline::test
