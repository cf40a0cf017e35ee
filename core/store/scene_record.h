#pragma once
/// The record of a scene in a data folder: which bytes its name has.
///
/// A record is one line of JSON. Its last member, `checksum`, is the SHA-256 of the text before the
/// comma that precedes it. Folders of format 1 also have records without a checksum.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/node_changes.h"

namespace sightline {

/// A file beside the scene's, by the name that the scene's file has for it.
struct NeighbourRecord {
  std::string name;
  std::string sha256;
  std::uint64_t bytes = 0;
};

struct SceneRecord {
  std::string id;
  std::string sha256;
  std::uint64_t bytes = 0;
  std::uint64_t revision = 0;
  std::optional<std::uint32_t> scene;  ///< which scene of the file; empty: the file's choice
  std::vector<NeighbourRecord> neighbours = {};
  /// hash_in_pieces of the bytes: quicker to check than their SHA-256, and enough against damage.
  /// Empty in records of older versions.
  std::optional<std::uint64_t> fingerprint = {};
  NodeChanges changes = {};  ///< since the file came
};

/// A longer text is no record.
inline constexpr std::size_t kRecordLimit = 16 << 20;

/// Equal only where the changes are; empty where there are none.
std::string tag_of(const NodeChanges& changes);

/// Which records are valid.
enum class RecordForm {
  kChecked,  ///< those with a checksum
  kAny,      ///< those without one too, as versions before format 2 wrote them
};

std::string encode_record(const SceneRecord& record);
/// Empty when the text is no record of this id: the checksum differs, a member is missing, unknown
/// or out of range.
std::optional<SceneRecord> decode_record(const std::string& text, const std::string& id,
                                         RecordForm form);

}  // namespace sightline
