#pragma once
/// OriginScenes: the scenes of an origin, and the numbers of their contents.
///
///   names/<id>/<number>   a content of a scene: its record (scene_record.h), or, if the object is
///                         empty, the fact that the scene was removed. 16 decimal digits
///   blobs/<sha256>        the bytes of a file
///   trees/<file>          trees that were built (tree_folder.h); a cache
///
/// The content with the largest number is the content of the scene. Each change creates the object
/// of the next number. Of several servers that try at once, one succeeds, and the others list the
/// numbers again. This is compare-and-swap. It needs nothing of the store but that it creates an
/// object once. [RFC9110] 13.1.2 defines the condition `If-None-Match: *` for it.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/store/origin.h"
#include "core/store/scene_record.h"

namespace sightline {

/// The number of a content in an origin.
struct Generation {
  std::uint64_t number = 0;  ///< 0: there never was a content of this name
  bool removed = false;      ///< the scene was removed by this change
  /// True if there is a content.
  bool stands() const { return number > 0 && !removed; }
};

/// The scenes of an origin. Thread-safe.
class OriginScenes {
 public:
  /// `origin` is not null.
  explicit OriginScenes(std::shared_ptr<Origin> origin) : origin_(std::move(origin)) {}

  /// Checks that the origin creates an object only once, unless an earlier call has. Errors:
  /// ORIGIN_UNSAFE (it overwrites: nothing may be written), those of Origin.
  Status probe();

  /// The newest content of a scene, by one request. `known` is a number that it had earlier, or 0.
  Result<Generation> newest(const std::string& id, std::uint64_t known = 0);
  /// The newest contents of all scenes, removed ones included; one request for 1,000 contents.
  Result<std::map<std::string, Generation>> newest_of_all();
  /// Reads the record of a content. Errors: ORIGIN_DAMAGED, those of Origin.
  Result<SceneRecord> read_record(const std::string& id, std::uint64_t number);

  /// Makes a content the newest of its scene; record.revision is its number, one more than the
  /// present newest. Returns false if another server was first. Errors: those of probe() and of
  /// Origin, CHANGES_TOO_MANY (the record exceeds kRecordLimit).
  Result<bool> publish(const SceneRecord& record);
  /// Removes a scene, as above.
  Result<bool> publish_removal(const std::string& id, std::uint64_t number);

  /// Stores a file, unless it is there. Errors: those of probe() and of Origin.
  Status store_bytes(const std::string& sha256, const FileDescriptor& file, std::uint64_t bytes);
  /// Passes the bytes of a file to `sink`, in pieces. The caller checks their hash. Errors:
  /// ORIGIN_DAMAGED (there is no such file), those of Origin and of `sink`.
  Status read_bytes(const std::string& sha256,
                    const std::function<Status(std::span<const std::byte>)>& sink);

  /// Stores a file of trees under its name, unless it is there. Errors: as store_bytes.
  Status store_trees(const std::string& name, const FileDescriptor& file, std::uint64_t bytes);
  /// Passes a file of trees to `sink`. Returns false if there is none. Errors: those of Origin and
  /// of `sink`.
  Result<bool> read_trees(const std::string& name,
                          const std::function<Status(std::span<const std::byte>)>& sink) {
    return origin_->read("trees/" + name, sink);
  }

 private:
  const std::shared_ptr<Origin> origin_;
  std::mutex mutex_;  ///< protects is_safe_
  bool is_safe_ = false;
};

/// The error of an origin whose content is wrong: ORIGIN_DAMAGED.
Error origin_damaged(std::string what);

}  // namespace sightline

// Tests: tests/unit/store/origin_test.cpp
