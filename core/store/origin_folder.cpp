#include "core/store/origin_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <system_error>

#include "core/store/temporary_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWriting = "write to the origin";
constexpr const char* kReading = "read from the origin";
constexpr const char* kWritingFolder = "writing";
constexpr std::size_t kCopiedAtOnce = 1 << 20;

/// A new file in `folder` whose name no other process has.
Result<TemporaryFile> unique_file(const fs::path& folder) {
  std::string path = (folder / "XXXXXX").string();
  FileDescriptor file(::mkostemp(path.data(), O_CLOEXEC));
  if (file.number() < 0) return io_error(kWriting, errno);
  ::fchmod(file.number(), 0640);
  return TemporaryFile(std::move(file), path);
}

Status copy(const FileDescriptor& from, std::uint64_t bytes, const FileDescriptor& to) {
  std::vector<std::byte> piece(std::min<std::uint64_t>(bytes, kCopiedAtOnce));
  for (std::uint64_t done = 0; done < bytes;) {
    const auto part = std::span(piece).first(std::min<std::uint64_t>(piece.size(), bytes - done));
    const auto got = read_at(from, done, part, kWriting);
    if (!got) return got.error();
    if (*got != part.size()) return io_error(kWriting, EIO);
    if (Status status = write_all(to, part, kWriting); !status) return status;
    done += *got;
  }
  return success();
}

}  // namespace

Result<std::unique_ptr<OriginFolder>> OriginFolder::open(const fs::path& folder) {
  constexpr const char* kDoing = "open the origin";
  if (Status made = make_folder(folder / kWritingFolder, kDoing); !made) {
    return std::move(made).error();
  }
  return std::unique_ptr<OriginFolder>(new OriginFolder(folder));
}

Result<bool> OriginFolder::create_with(const std::string& name,
                                       const std::function<Status(const FileDescriptor&)>& fill) {
  const fs::path target = folder_ / name;
  std::error_code error;
  if (fs::exists(target, error)) return false;
  auto temporary = unique_file(folder_ / kWritingFolder);
  if (!temporary) return std::move(temporary).error();
  if (Status status = fill(temporary->file()); !status) return std::move(status).error();
  if (Status status = sync_file(temporary->file(), kWriting); !status) {
    return std::move(status).error();
  }
  if (Status made = make_folder(target.parent_path(), kWriting); !made) {
    return std::move(made).error();
  }
  if (::link(temporary->path().c_str(), target.c_str()) != 0) {
    if (errno == EEXIST) return false;
    return io_error(kWriting, errno);
  }
  if (Status status = sync_folder(target.parent_path(), kWriting); !status) {
    return std::move(status).error();
  }
  return true;
}

Result<bool> OriginFolder::create(const std::string& name, std::string_view content) {
  return create_with(name, [&](const FileDescriptor& file) {
    return write_all(file, std::as_bytes(std::span(content)), kWriting);
  });
}

Result<bool> OriginFolder::create(const std::string& name, const FileDescriptor& file,
                                  std::uint64_t bytes) {
  return create_with(name, [&](const FileDescriptor& to) { return copy(file, bytes, to); });
}

Result<bool> OriginFolder::read(const std::string& name,
                                const std::function<Status(std::span<const std::byte>)>& sink) {
  const fs::path path = folder_ / name;
  std::error_code error;
  if (!fs::exists(path, error) && !error) return false;
  const auto file = open_file(path, O_RDONLY, kReading);
  if (!file) return file.error();
  std::vector<std::byte> piece(kCopiedAtOnce);
  for (std::uint64_t done = 0;;) {
    const auto got = read_at(*file, done, piece, kReading);
    if (!got) return got.error();
    if (*got == 0) return true;
    if (Status status = sink(std::span(piece).first(*got)); !status) {
      return std::move(status).error();
    }
    done += *got;
  }
}

Result<std::vector<OriginObject>> OriginFolder::list(const std::string& prefix,
                                                     const std::string& after) {
  std::vector<OriginObject> objects;
  std::error_code error;
  const fs::path root = folder_ / prefix;  // ends with '/', and paths below it begin with it
  for (fs::recursive_directory_iterator each(root, error), end; each != end;) {
    std::string name = prefix + each->path().native().substr(root.native().size());
    // The entry of a folder has the kind. The size costs a request: only listed names are asked.
    std::error_code gone;  // a file may vanish meanwhile
    if (name > after && each->is_regular_file(gone)) {
      const std::uint64_t bytes = each->file_size(gone);
      if (!gone) objects.push_back({std::move(name), bytes});
    }
    each.increment(error);
    if (error) break;
  }
  if (error == std::errc::no_such_file_or_directory) return objects;
  if (error) return io_error(kReading, error.value());
  std::sort(objects.begin(), objects.end(),
            [](const OriginObject& a, const OriginObject& b) { return a.name < b.name; });
  return objects;
}

Status OriginFolder::remove(const std::string& name) {
  if (::unlink((folder_ / name).c_str()) != 0 && errno != ENOENT) return io_error(kWriting, errno);
  return success();
}

}  // namespace sightline
