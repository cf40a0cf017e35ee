#pragma once
/// OriginFolder: an Origin in a folder that the servers share, on one machine or over NFS.

#include <filesystem>
#include <memory>

#include "core/store/origin.h"

namespace sightline {

/// Objects are files below a folder. A file is written under another name in DIR/writing, synced,
/// and then linked to its name with link(2), which fails if the name exists.
class OriginFolder final : public Origin {
 public:
  /// Makes the folder if there is none. Errors: those of io_error.
  static Result<std::unique_ptr<OriginFolder>> open(const std::filesystem::path& folder);

  Result<bool> create(const std::string& name, std::string_view content) override;
  Result<bool> create(const std::string& name, const FileDescriptor& file,
                      std::uint64_t bytes) override;
  Result<bool> read(const std::string& name,
                    const std::function<Status(std::span<const std::byte>)>& sink) override;
  Result<std::vector<OriginObject>> list(const std::string& prefix,
                                         const std::string& after) override;
  Status remove(const std::string& name) override;

 private:
  explicit OriginFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}
  /// Creates an object with the bytes that `fill` writes.
  Result<bool> create_with(const std::string& name,
                           const std::function<Status(const FileDescriptor&)>& fill);

  std::filesystem::path folder_;
};

}  // namespace sightline

// Tests: tests/unit/store/origin_test.cpp
