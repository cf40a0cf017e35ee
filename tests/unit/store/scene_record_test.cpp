// The text of a scene's record: every damage is noticed.

#include "core/store/scene_record.h"

#include <gtest/gtest.h>

#include "tests/unit/store/text_scenes.h"

namespace sightline {
namespace {

/// A record with every member that the format has.
SceneRecord full_record() {
  SceneRecord record{"town", hash("file"), 4, 7, 3};
  record.fingerprint = 0x0123456789abcdef;
  record.neighbours = {{"b uffer.bin", hash("buffer"), 6}, {"image.png", hash("image"), 5}};
  NodeChange moved{2, Affine{}, {}, 6};
  moved.parent_from_node->m[2][3] = 0.1;
  NodeChange added{50, {}, {}, {}, {}, AddedNode{12, 2, "a \"crate\""}};
  NodeChange removed{14, {}, {}, {}};
  removed.removed = true;
  added.positions = {{0.1f, -0.0f, 3e38f}, {1, 2, 1e-45f}};
  record.changes = {moved, {12, {}, true, {}}, {13, {}, {}, {}, {0.1, -2}}, removed, added};
  return record;
}

/// As versions before the checksum wrote it.
std::string without_checksum(const SceneRecord& record) {
  const std::string text = encode_record(record);
  const std::size_t end = text.find(",\"checksum\":");
  return text.substr(0, end) + "}\n";
}

std::string text_again(const std::string& text, RecordForm form) {
  const auto record = decode_record(text, "town", form);
  return record ? encode_record(*record) : "none";
}

TEST(SceneRecord, comes_back_as_it_was_written) {
  for (const SceneRecord& record : {full_record(), SceneRecord{"town", hash("file"), 4, 7, {}}}) {
    const std::string text = encode_record(record);
    EXPECT_EQ(text_again(text, RecordForm::kChecked), text);
    EXPECT_EQ(text_again(text, RecordForm::kAny), text);
  }
}

TEST(SceneRecord, is_read_without_its_changes) {
  SceneRecord record = full_record();
  record.neighbours[0].name = "a,\"changes\":[";  // as text, where the changes begin
  const std::string text = encode_record(record), older = without_checksum(record);
  record.changes.clear();
  const auto read = decode_record(text, "town", RecordForm::kAny, RecordPart::kWithoutChanges);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(encode_record(*read), encode_record(record));
  EXPECT_FALSE(
      decode_record(text.substr(1), "town", RecordForm::kChecked, RecordPart::kWithoutChanges));
  const auto whole = decode_record(older, "town", RecordForm::kAny, RecordPart::kWithoutChanges);
  ASSERT_TRUE(whole.has_value());
  EXPECT_EQ(encode_record(*whole), text);
}

TEST(SceneRecord, of_an_older_version_is_read_where_the_folder_is_older) {
  const std::string text = without_checksum(full_record());
  EXPECT_EQ(text_again(text, RecordForm::kChecked), "none");
  EXPECT_EQ(text_again(text, RecordForm::kAny), encode_record(full_record()));
}

TEST(SceneRecord, is_refused_with_any_bit_flipped) {
  const std::string good = encode_record(full_record());
  for (const RecordForm form : {RecordForm::kChecked, RecordForm::kAny}) {
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
      std::string bad = good;
      bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ (1 << bit % 8));
      ASSERT_EQ(text_again(bad, form), "none") << "bit " << bit % 8 << " of byte " << bit / 8;
    }
  }
}

TEST(SceneRecord, is_refused_with_any_byte_missing_or_any_end_cut) {
  const std::string good = encode_record(full_record());
  for (const RecordForm form : {RecordForm::kChecked, RecordForm::kAny}) {
    for (std::size_t at = 0; at < good.size(); ++at) {
      EXPECT_EQ(text_again(good.substr(0, at), form), "none") << at;
      EXPECT_EQ(text_again(good.substr(0, at) + good.substr(at + 1), form), "none") << at;
    }
    EXPECT_EQ(text_again(good + "\n", form), "none");
    EXPECT_EQ(text_again(good + good, form), "none");
  }
}

TEST(SceneRecord, of_an_older_version_is_refused_with_a_key_or_a_value_that_it_cannot_have) {
  const std::string good = without_checksum(full_record());
  const std::pair<std::string, std::string> edits[] = {
      {"\"fingerprint\"", "\"fingerprinu\""},
      {"\"neighbours\"", "\"neighbourt\""},
      {"\"changes\"", "\"chances\""},
      {"\"scene\"", "\"scend\""},
      {"\"scene\":3", "\"scene\":4294967296"},
      {"\"scene\":3", "\"scene\":\"3\""},
      {"\"hidden\"", "\"hiddeo\""},
      {"\"mask\"", "\"masj\""},
      {"\"mask\":6", "\"mask\":4294967296"},
      {"\"weights\":[0.1,", "\"weights\":[null,"},
      {"\"weights\":[", "\"weights\":[[],"},
      {"\"matrix\"", "\"matriy\""},
      {"\"copy_of\"", "\"copy_og\""},
      {"\"copy_of\":12,", ""},
      {"\"copy_of\":12", "\"copy_of\":-12"},
      {"\"parent\":2", "\"parent\":null"},
      {"\"name\":\"a ", "\"nam\":\"a "},
      {"\"removed\":true", "\"removed\":1"},
      {"\"positions\"", "\"positiont\""},
      {"\"positions\":\"3", "\"positions\":\""},
      {"\"positions\":\"3", "\"positions\":\"-"},
      {"\"positions\":\"3dcccccd", "\"positions\":\"3Dcccccd"},
      {"\"positions\":\"3dcccccd", "\"positions\":\"7f800000"},
      {"\"removed\"", "\"removee\""},
      {"\"node\":2", "\"node\":4294967296"},
      {"\"fingerprint\":", "\"fingerprint\":-"},
      {"\"bytes\":6", "\"bytes\":6,\"other\":6"},
  };
  for (const auto& [from, to] : edits) {
    std::string bad = good;
    const std::size_t at = bad.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    bad.replace(at, from.size(), to);
    EXPECT_EQ(text_again(bad, RecordForm::kAny), "none") << to;
  }
}

}  // namespace
}  // namespace sightline
