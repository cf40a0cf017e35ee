#pragma once
/// What is done in a process of its own and measured there: a file becomes a scene and answers
/// rays, with everything skipped that can be, or with nothing skipped.

#include <filesystem>
#include <nlohmann/json.hpp>

namespace sightline::bench {

/// From the file to its 10,000th answer: seconds to the first one, meshes built on the way, bytes
/// read, the peak of memory, and a hash of all answers. Trees are built when rays come near
/// (`lazy`), or all before the first ray, and then nothing of the file is skipped either.
nlohmann::json run_rays(const std::filesystem::path& file, bool lazy);

/// As a server has it: trees are built ahead and kept in `folder`. Seconds to the first answer and
/// to the end of building; the peak of memory and what is left of it.
nlohmann::json run_server(const std::filesystem::path& file, const std::filesystem::path& folder);

/// Maps the file, reads its bytes once and builds Embree's tree of medium quality over its meshes.
nlohmann::json run_embree(const std::filesystem::path& file);

/// Writes the file unless it is there: "terrain_10M.glb" is one mesh, "distinct_10k.glb" 10,000.
bool make_file(const std::filesystem::path& file, unsigned smaller);

/// Has the file written to its disk and read once: what was just made, or was never read, would
/// make the first run that meets it wait. False if it cannot be read.
bool settle_file(const std::filesystem::path& file);

}  // namespace sightline::bench
