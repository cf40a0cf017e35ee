#pragma once
/// Scenes for tests of the store: the "file format" is any text, which becomes the scene's name.

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/store/scene_store.h"

namespace sightline {

/// Refuses text that begins with "bad" (code TEXT_BAD) and throws at text that begins with "throw".
Result<std::shared_ptr<const Scene>> load_text(const LoadInput& input);
/// The scene of a text that is not in any store.
std::shared_ptr<const Scene> text_scene(std::string_view text);

/// The text on its way to the store.
Result<IncomingScene> send_text(SceneStore& store, const std::string& id, std::string_view text,
                                const SceneChoice& choice = {});
/// The same, until the outcome.
Result<Put> put_text(SceneStore& store, const std::string& id, std::string_view text,
                     const SceneChoice& choice = {});
/// The text of a ready scene, else its state in brackets: "[failed]", "[none]".
/// SHA-256 in hexadecimal.
std::string hash(std::string_view text);
std::string text_of(const SceneStore& store, const std::string& id);
std::unique_ptr<SceneStore> open_store(const std::filesystem::path& folder,
                                       std::vector<Preload> preloads = {});
/// The same, when everything of the start is ready or failed.
std::unique_ptr<SceneStore> open_settled(const std::filesystem::path& folder,
                                         std::vector<Preload> preloads = {});
void wait_until_settled(const SceneStore& store);

/// A new empty folder, removed with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  /// Names of the files in a folder below, sorted.
  std::vector<std::string> files(std::string_view below) const;

 private:
  std::filesystem::path path_;
};

}  // namespace sightline
