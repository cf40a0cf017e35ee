#pragma once
/// Checks whether a server could store scenes in a folder, without leaving anything there.

#include <filesystem>

#include "core/base/result.h"

namespace sightline {

/// Checks a data folder. If it does not exist, checks that it could be made, by making and removing
/// another one in its nearest existing parent. It is no error if a server uses the folder now. Errors:
/// DATA_FOLDER_UNFIT.
Status check_data_folder(const std::filesystem::path& folder);

}  // namespace sightline

// Tests: tests/integration/settings_test.py
