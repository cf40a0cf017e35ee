#pragma once
/// SceneRecord: the record of a scene in a data folder, which names its bytes.
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

/// A neighbour of the scene's file (scene_neighbours.h).
struct NeighbourRecord {
  /// As the scene's file refers to it.
  std::string name;
  std::string sha256;
  std::uint64_t bytes = 0;
};

/// A record.
struct SceneRecord {
  std::string id;              ///< name of the scene
  std::string sha256;          ///< of the scene's file
  std::uint64_t bytes = 0;     ///< size of the scene's file
  std::uint64_t revision = 0;  ///< number of the content (revision_counter.h)
  /// index of the chosen scene of the file; empty: the file's default
  std::optional<std::uint32_t> scene;
  std::vector<NeighbourRecord> neighbours = {};
  /// hash_in_pieces of the bytes. It is faster to check than SHA-256, and sufficient to detect
  /// damage. Empty in records of older versions.
  std::optional<std::uint64_t> fingerprint = {};
  NodeChanges changes = {};  ///< changes of nodes since the file was loaded
};

/// The largest size of a record in bytes.
inline constexpr std::size_t kRecordLimit = 16 << 20;

/// A tag of a list of changes: a hash of all of them. Empty if there are none.
std::string tag_of(const NodeChanges& changes);

/// Which records are accepted.
enum class RecordForm {
  kChecked,  ///< only records with a checksum
  kAny,      ///< also records without one, which versions before format 2 wrote
};

/// What of a record is decoded.
enum class RecordPart {
  kWhole,
  /// `changes` stays empty if the record has a checksum. Changes of 4,000 nodes take 10 ms to
  /// decode, and each PATCH reads the record.
  kWithoutChanges,
};

/// Returns the text of a record, with its checksum.
std::string encode_record(const SceneRecord& record);
/// Returns the record, or empty if the text is not a valid record of the scene `id`: its checksum
/// differs, or a member is missing, unknown or out of range.
std::optional<SceneRecord> decode_record(const std::string& text, const std::string& id,
                                         RecordForm form, RecordPart part = RecordPart::kWhole);

}  // namespace sightline
