#pragma once
/// Placeholder shape of the two-level tree; filled in by the next commit.

namespace sightline {
class SceneTree {};
}  // namespace sightline
