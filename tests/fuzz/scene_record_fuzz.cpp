// Records of scenes: refused, or written again as a text that reads as this text.
// Run:  scripts/stress.sh fuzz --target scene_record_fuzz

#include <cmath>
#include <cstdint>
#include <string>

#include "core/store/scene_record.h"
#include "tests/fuzz/promise.h"

using namespace sightline;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using fuzz::require;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const bool is_checked = decode_record(text, "six", RecordForm::kChecked).has_value();
  const auto record = decode_record(text, "six", RecordForm::kAny);
  require(record || !is_checked, "a record with a checksum is a record");
  require(!decode_record(text, "other", RecordForm::kAny), "a record is that of one scene");
  if (!record) return 0;
  require(record->id == "six" && record->sha256.size() == 64, "records name their bytes");
  for (const NodeChange& change : record->changes) {
    for (const double weight : change.weights) require(std::isfinite(weight), "weights are finite");
    for (const Vec3f& p : change.positions) {
      require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z),
              "vertices are finite");
    }
  }
  const std::string written = encode_record(*record);
  const auto again = decode_record(written, "six", RecordForm::kChecked);
  require(again.has_value(), "what is written is a record");
  require(encode_record(*again) == written, "records are written alike");
  require(again->changes == record->changes, "changes read alike");
  auto head = decode_record(written, "six", RecordForm::kChecked, RecordPart::kWithoutChanges);
  require(head && head->changes.empty(), "what is written is a record without changes too");
  head->changes = record->changes;
  require(encode_record(*head) == written, "the other members read alike");
  require(tag_of(again->changes) == tag_of(record->changes), "tags are equal");
  return 0;
}
