#pragma once
/// make_unlinked_file: a temporary file without a name, which the system removes when nothing refers
/// to it.

#include <string>

namespace sightline {

/// Makes an empty file in `folder` for reading and writing, which only this process can open. Returns
/// its descriptor, which the caller closes; -1 with errno if there can be none.
int make_unlinked_file(const std::string& folder);

}  // namespace sightline

// Tests: tests/unit/base/overflow_memory_test.cpp
