#include "tests/unit/store/text_scenes.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <stdexcept>
#include <thread>

#include "core/store/sha256.h"

namespace sightline {

namespace fs = std::filesystem;

Result<std::shared_ptr<const Scene>> load_text(const LoadInput& input) {
  SceneDescription description;
  for (const std::byte byte : input.bytes) description.name += static_cast<char>(byte);
  if (description.name.starts_with("bad")) {
    return Error{ErrorKind::kInvalid, "TEXT_BAD", "this text is bad", ""};
  }
  if (description.name.starts_with("throw")) throw std::runtime_error("secret");
  if (const auto chosen = input.choice.scene) {
    description.name += " scene " + std::to_string(*chosen);
  }
  return Scene::build(std::move(description));
}

std::shared_ptr<const Scene> text_scene(std::string_view text) {
  SceneDescription description;
  description.name = text;
  return *Scene::build(std::move(description));
}

Result<IncomingScene> send_text(SceneStore& store, const std::string& id, std::string_view text,
                                const SceneChoice& choice) {
  auto incoming = store.begin(id, choice);
  if (!incoming) return incoming;
  // In two pieces, as bodies come.
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  for (const auto piece : {bytes.first(bytes.size() / 2), bytes.subspan(bytes.size() / 2)}) {
    if (Status status = incoming->append(piece); !status) return std::move(status).error();
  }
  return incoming;
}

Result<Put> put_text(SceneStore& store, const std::string& id, std::string_view text,
                     const SceneChoice& choice) {
  auto incoming = send_text(store, id, text, choice);
  if (!incoming) return std::move(incoming).error();
  return *store.wait(*store.submit(std::move(*incoming)), Deadline::never());
}

std::string hash(std::string_view text) {
  return sha256_of(std::as_bytes(std::span(text.data(), text.size())));
}

std::string text_of(const SceneStore& store, const std::string& id) {
  const SceneSnapshot scene = store.find(id);
  if (!scene) return "[none]";
  if (scene->state != SceneState::kReady)
    return std::string("[") + scene_state_name(scene->state) + "]";
  return scene->scene->description().name;
}

std::unique_ptr<SceneStore> open_store(const fs::path& folder, std::vector<Preload> preloads) {
  auto store =
      SceneStore::open({.folder = folder, .loads_at_once = 2}, load_text, std::move(preloads));
  if (!store) {
    ADD_FAILURE() << store.error().code << " " << store.error().message;
    return nullptr;
  }
  return std::move(*store);
}

std::unique_ptr<SceneStore> open_settled(const fs::path& folder, std::vector<Preload> preloads) {
  auto store = open_store(folder, std::move(preloads));
  if (store) wait_until_settled(*store);
  return store;
}

void wait_until_settled(const SceneStore& store) {
  while (!store.settled()) std::this_thread::yield();
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "sightline-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) ADD_FAILURE() << "no temporary folder";
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code error;
  fs::remove_all(path_, error);
}

std::vector<std::string> TemporaryFolder::files(std::string_view below) const {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(path_ / below)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace sightline
