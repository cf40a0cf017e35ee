#include "core/store/temporary_file.h"

#include <fcntl.h>
#include <unistd.h>

namespace sightline {

TemporaryFile::~TemporaryFile() {
  if (!path_.empty()) ::unlink(path_.c_str());
}

Result<TemporaryFile> make_temporary(std::filesystem::path path, const char* doing) {
  auto file = open_file(path, O_RDWR | O_CREAT | O_TRUNC | O_NOFOLLOW, doing);
  if (!file) return std::move(file).error();
  return TemporaryFile(std::move(*file), std::move(path));
}

Status fill_durably(TemporaryFile& temporary, std::string_view text, const char* doing) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  if (Status status = write_all(temporary.file(), bytes, doing); !status) return status;
  return sync_file(temporary.file(), doing);
}

Status write_durably(TemporaryFile& temporary, std::string_view text,
                     const std::filesystem::path& target, const char* doing) {
  if (Status status = fill_durably(temporary, text, doing); !status) return status;
  if (Status status = rename_file(temporary.path(), target, doing); !status) return status;
  temporary.release();
  return sync_folder(target.parent_path(), doing);
}

}  // namespace sightline
