#include "core/store/scene_neighbours.h"

#include "core/store/sha256.h"

namespace sightline {
namespace {

constexpr std::size_t kMostNeighbours = 4096;

}  // namespace

std::string tag_of(const std::vector<NeighbourRecord>& neighbours) {
  if (neighbours.empty()) return {};
  std::string text;
  for (const NeighbourRecord& each : neighbours) text += each.sha256 + " " + each.name + "\n";
  return sha256_of(std::as_bytes(std::span(text.data(), text.size())));
}

Result<std::span<const std::byte>> CopiedNeighbours::find(const std::string& name) {
  const auto bytes_of = [](const Copy& copy) {
    return copy.read ? copy.read->bytes() : copy.upload.memory();
  };
  for (const Copy& copy : copies_) {
    if (copy.record.name == name) return bytes_of(copy);
  }
  if (copies_.size() == kMostNeighbours) {
    return Error{ErrorKind::kTooLarge, "NEIGHBOURS_TOO_MANY",
                 "a scene may have " + std::to_string(kMostNeighbours) + " other files", ""};
  }
  auto upload = begin_upload(folder_, memory_);
  if (!upload) return std::move(upload).error();
  Copy copy{{name, "", 0}, std::move(*upload), std::nullopt};
  Status status =
      source_(name, [&](std::span<const std::byte> piece) { return copy.upload.append(piece); });
  if (!status) return std::move(status).error();
  copy.record.sha256 = copy.upload.finish_hash();
  copy.record.bytes = copy.upload.size();
  if (copy.record.sha256.empty()) {
    return Error{ErrorKind::kInternal, "HASH_FAILED", "the SHA-256 could not be computed", ""};
  }
  if (auto& file = copy.upload.file()) {
    constexpr const char* kDoing = "store a scene's other file";
    if (Status synced = sync_file(file->file(), kDoing); !synced) return std::move(synced).error();
    auto read = FileBytes::read(file->file(), kDoing);
    if (!read) return std::move(read).error();
    copy.read.emplace(std::move(*read));
    // There may be thousands of them, and fewer descriptors.
    file->close();
  }
  copies_.push_back(std::move(copy));
  return bytes_of(copies_.back());
}

std::vector<NeighbourRecord> CopiedNeighbours::records() const {
  std::vector<NeighbourRecord> records;
  for (const Copy& copy : copies_) records.push_back(copy.record);
  return records;
}

std::vector<TemporaryFile*> CopiedNeighbours::files() {
  std::vector<TemporaryFile*> files;
  for (Copy& copy : copies_) {
    if (copy.upload.file()) files.push_back(&*copy.upload.file());
  }
  return files;
}

Result<StoredNeighbours> StoredNeighbours::read(SceneFolder& folder, const SceneRecord& record,
                                                SceneFolder::File& failed) {
  StoredNeighbours neighbours;
  for (const NeighbourRecord& each : record.neighbours) {
    auto read = folder.read_bytes(each.sha256, each.bytes);
    if (!read) {
      failed = {each.sha256, each.bytes};
      return std::move(read).error();
    }
    neighbours.add(each.name, std::move(*read));
  }
  return neighbours;
}

Result<std::span<const std::byte>> StoredNeighbours::find(const std::string& name) const {
  for (const auto& [known, read] : files_) {
    if (known == name) return read.bytes();
  }
  return Error{ErrorKind::kInvalid, "SOURCE_NOT_FOUND", "there is no such file beside the scene",
               ""};
}

}  // namespace sightline
