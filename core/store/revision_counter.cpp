#include "core/store/revision_counter.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>

#include "core/store/temporary_file.h"

namespace sightline {
namespace {

constexpr const char* kName = "revision";
constexpr const char* kNewName = "revision.new";
constexpr std::uint64_t kLeftOut = std::uint64_t{1} << 32;

/// One line: the number.
std::optional<std::uint64_t> decode_revision(const std::string& text) {
  std::uint64_t number = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, number);
  const bool whole = error == std::errc() && last + 1 == end && *last == '\n';
  if (!whole || number > kMostRevision) return std::nullopt;
  return number;
}

}  // namespace

Result<RevisionCounter> RevisionCounter::open(const std::filesystem::path& folder,
                                              std::uint64_t seen) {
  std::error_code error;
  for (const char* name : {kName, kNewName}) {
    if (!std::filesystem::is_directory(std::filesystem::symlink_status(folder / name, error)))
      continue;
    return Error{ErrorKind::kConflict, "STORE_DAMAGED",
                 (folder / name).string() +
                     " is a folder, where the file of the last revision belongs: move it away, and "
                     "start again",
                 ""};
  }
  if (!std::filesystem::exists(folder / kName, error) && !error)
    return RevisionCounter(folder, seen);
  const auto text = read_small_file(folder / kName, 64, "read the number of the last revision");
  const auto stated = text ? decode_revision(*text) : std::nullopt;
  return RevisionCounter(folder, stated ? std::max(seen, *stated) : seen + kLeftOut);
}

Result<std::uint64_t> RevisionCounter::next(std::uint64_t count) {
  constexpr const char* kDoing = "number the scene";
  last_ += count;
  if (folder_.empty()) return last_;
  auto temporary = make_temporary(folder_ / kNewName, kDoing);
  if (!temporary) return std::move(temporary).error();
  Status status = write_durably(*temporary, std::to_string(last_) + "\n", folder_ / kName, kDoing);
  if (!status) return std::move(status).error();
  return last_;
}

}  // namespace sightline
