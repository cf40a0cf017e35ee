#include "core/store/origin_scenes.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <random>
#include <utility>

#include "core/store/revision_counter.h"
#include "core/store/scene_id.h"

namespace sightline {
namespace {

constexpr std::string_view kNames = "names/";

std::string name_of(const std::string& id, std::uint64_t number) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%016llu", static_cast<unsigned long long>(number));
  return std::string(kNames) + id + "/" + digits;
}

/// The scene and the content that an object stands for; empty for an object of another kind.
std::optional<std::pair<std::string, Generation>> generation_of(const OriginObject& object) {
  constexpr std::size_t kDigits = 16;
  std::string_view rest = object.name;
  if (!rest.starts_with(kNames)) return std::nullopt;
  rest.remove_prefix(kNames.size());
  const std::size_t slash = rest.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const std::string_view id = rest.substr(0, slash), digits = rest.substr(slash + 1);
  Generation generation{0, object.bytes == 0};
  const auto read =
      std::from_chars(digits.data(), digits.data() + digits.size(), generation.number);
  const bool is_number = digits.size() == kDigits && read.ec == std::errc() &&
                         read.ptr == digits.data() + digits.size();
  if (!is_number || generation.number > kMostRevision || !is_scene_id(id)) return std::nullopt;
  return std::pair(std::string(id), generation);
}

Error origin_unsafe() {
  return {ErrorKind::kConflict, "ORIGIN_UNSAFE",
          "the origin overwrites objects in spite of If-None-Match: *, so two servers could lose "
          "each other's changes; it can only be read",
          ""};
}

}  // namespace

Error origin_damaged(std::string what) {
  return {ErrorKind::kInternal, "ORIGIN_DAMAGED", std::move(what), ""};
}

Status OriginScenes::probe() {
  const std::lock_guard hold(mutex_);
  if (is_safe_) return success();
  std::random_device random;
  std::string name = "probe/";
  for (int i = 0; i < 4; ++i) name += std::to_string(random()) + (i < 3 ? "-" : "");
  const auto first = origin_->create(name, "first");
  if (!first) return first.error();
  const auto second = origin_->create(name, "second");
  std::string content;
  const auto read = origin_->read(name, [&](std::span<const std::byte> piece) {
    content.append(reinterpret_cast<const char*>(piece.data()), piece.size());
    return success();
  });
  Status removed = origin_->remove(name);
  if (!second) return second.error();
  if (!read) return read.error();
  if (!removed) return removed;
  if (!*first || *second || !*read || content != "first") return origin_unsafe();
  is_safe_ = true;
  return success();
}

Result<Generation> OriginScenes::newest(const std::string& id, std::uint64_t known) {
  const auto objects = origin_->list(std::string(kNames) + id + "/",
                                     known > 1 ? name_of(id, known - 1) : std::string());
  if (!objects) return objects.error();
  Generation newest;
  for (const OriginObject& object : *objects) {
    const auto found = generation_of(object);
    if (found && found->second.number > newest.number) newest = found->second;
  }
  return newest;
}

Result<std::map<std::string, Generation>> OriginScenes::newest_of_all() {
  const auto objects = origin_->list(std::string(kNames), "");
  if (!objects) return objects.error();
  std::map<std::string, Generation> all;
  for (const OriginObject& object : *objects) {
    const auto found = generation_of(object);
    if (!found) continue;
    Generation& newest = all[found->first];
    if (found->second.number > newest.number) newest = found->second;
  }
  return all;
}

Result<SceneRecord> OriginScenes::read_record(const std::string& id, std::uint64_t number) {
  std::string text;
  const auto read =
      origin_->read(name_of(id, number), [&](std::span<const std::byte> piece) -> Status {
        if (text.size() + piece.size() > kRecordLimit) {
          return origin_damaged("a record in the origin is too large");
        }
        text.append(reinterpret_cast<const char*>(piece.data()), piece.size());
        return success();
      });
  if (!read) return read.error();
  auto record = *read ? decode_record(text, id, RecordForm::kChecked) : std::nullopt;
  if (!record || record->revision != number) {
    return origin_damaged("the record " + std::to_string(number) + " of the scene in the origin " +
                          (*read ? "is damaged" : "is missing"));
  }
  return *std::move(record);
}

Result<bool> OriginScenes::publish(const SceneRecord& record) {
  if (Status status = probe(); !status) return std::move(status).error();
  const std::string text = encode_record(record);
  if (text.size() > kRecordLimit) {
    return Error{ErrorKind::kTooLarge, "CHANGES_TOO_MANY",
                 "the changes of the scene's nodes take too much: send the file anew", ""};
  }
  return origin_->create(name_of(record.id, record.revision), text);
}

Result<bool> OriginScenes::publish_removal(const std::string& id, std::uint64_t number) {
  if (Status status = probe(); !status) return std::move(status).error();
  return origin_->create(name_of(id, number), "");
}

Status OriginScenes::store_bytes(const std::string& sha256, const FileDescriptor& file,
                                 std::uint64_t bytes) {
  if (Status status = probe(); !status) return status;
  const auto created = origin_->create("blobs/" + sha256, file, bytes);
  return created ? success() : Status(created.error());
}

Status OriginScenes::read_bytes(const std::string& sha256,
                                const std::function<Status(std::span<const std::byte>)>& sink) {
  const auto read = origin_->read("blobs/" + sha256, sink);
  if (!read) return read.error();
  return *read ? success() : Status(origin_damaged("a file of the scene is missing in the origin"));
}

Status OriginScenes::store_trees(const std::string& name, const FileDescriptor& file,
                                 std::uint64_t bytes) {
  if (Status status = probe(); !status) return status;
  const auto created = origin_->create("trees/" + name, file, bytes);
  return created ? success() : Status(created.error());
}

}  // namespace sightline
