#pragma once
/// Whether a server could store its scenes in a folder, tested without leaving anything there.

#include <filesystem>

#include "core/base/result.h"

namespace sightline {

/// Where the folder is not there yet, tries whether one could be made. A server that has it at this
/// moment is no mistake. Errors: DATA_FOLDER_UNFIT.
Status check_data_folder(const std::filesystem::path& folder);

}  // namespace sightline
