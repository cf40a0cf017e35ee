#include "server/operation/data_folder.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

namespace sightline {
namespace {

namespace fs = std::filesystem;

Error unfit(const std::string& why) { return {ErrorKind::kInvalid, "DATA_FOLDER_UNFIT", why, ""}; }

Error unfit_now(const fs::path& folder) {
  return unfit("cannot make or use '" + folder.string() +
               "': " + std::generic_category().message(errno));
}

}  // namespace

Status check_data_folder(const fs::path& folder) {
  std::error_code error;
  fs::path there = fs::absolute(folder, error);
  if (!there.has_filename()) there = there.parent_path();
  while (!fs::exists(there, error) && there != there.parent_path()) there = there.parent_path();
  if (!fs::is_directory(there, error)) return unfit("'" + there.string() + "' is no folder");
  if (::access(there.c_str(), R_OK | W_OK | X_OK) != 0) return unfit_now(there);
  if (fs::exists(folder, error)) return success();
  // Some folders, like those of /proc, let nobody make one whatever their permissions say.
  std::string probe = (there / "sightline-XXXXXX").string();
  if (::mkdtemp(probe.data()) == nullptr) return unfit_now(folder);
  ::rmdir(probe.c_str());
  return success();
}

}  // namespace sightline
