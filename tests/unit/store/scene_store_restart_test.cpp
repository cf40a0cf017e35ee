// What a data folder gives back to the next run.

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "core/store/scene_store.h"
#include "tests/unit/store/text_scenes.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

void write_file(const fs::path& file, std::string_view text) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

TEST(SceneStoreRestart, brings_every_acknowledged_scene_back) {
  const TemporaryFolder folder;
  {
    const auto store = open_store(folder.path());
    ASSERT_TRUE(put_text(*store, "town", "first").ok());
    ASSERT_TRUE(put_text(*store, "town", "second").ok());
    ASSERT_TRUE(put_text(*store, "gone", "third").ok());
    ASSERT_TRUE(store->remove("gone").ok());
    ASSERT_TRUE(put_text(*store, "chosen", "file", {.scene = 3}).ok());
  }
  const auto store = open_settled(folder.path());
  EXPECT_EQ(store->list().size(), 2u);
  EXPECT_EQ(text_of(*store, "town"), "second");
  EXPECT_EQ(text_of(*store, "chosen"), "file scene 3");
  const SceneSnapshot town = store->find("town");
  EXPECT_EQ(town->revision, 2u);
  EXPECT_EQ(town->etag, hash("second"));
  EXPECT_EQ(town->sha256, hash("second"));
  EXPECT_EQ(store->find("chosen")->etag, hash("file") + "-scene-3");
  EXPECT_EQ(town->bytes, 6u);
  EXPECT_TRUE(town->persistent);
}

TEST(SceneStoreRestart, names_a_folder_in_place_of_the_revision_file_and_loses_nothing) {
  const TemporaryFolder folder;
  ASSERT_TRUE(put_text(*open_store(folder.path()), "kept", "text").ok());
  const fs::path aside = folder.path() / "tmp" / "aside";
  for (const char* name : {"revision", "revision.new"}) {
    const fs::path place = folder.path() / name;
    const bool is_there = fs::exists(place);
    if (is_there) fs::rename(place, aside);
    fs::create_directory(place);
    const auto refused = SceneStore::open({.folder = folder.path()}, load_text, {});
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, "STORE_DAMAGED");
    EXPECT_NE(refused.error().message.find(place.string()), std::string::npos);
    fs::remove(place);
    if (is_there) fs::rename(aside, place);
  }
  EXPECT_EQ(open_settled(folder.path())->find("kept")->revision, 1u);
}

TEST(SceneStoreRestart, never_gives_a_revision_twice) {
  const TemporaryFolder folder;
  std::vector<std::uint64_t> given;
  const auto preload = [](Progress&) {
    return Result<PreloadedScene>(PreloadedScene{text_scene(""), hash(""), "", 0});
  };
  // The last start finds the file that counts damaged.
  for (const bool damaged : {false, false, true}) {
    if (damaged) write_file(folder.path() / "revision", "x");
    const auto store = open_settled(folder.path(), {{"made", preload}});
    given.push_back(store->find("made")->revision);
    ASSERT_TRUE(put_text(*store, "kept", "a").ok());
    given.push_back(store->find("kept")->revision);
    ASSERT_TRUE(put_text(*store, "gone", "b").ok());
    given.push_back(store->find("gone")->revision);
    ASSERT_TRUE(store->remove("gone").ok());
  }
  for (std::size_t i = 1; i < given.size(); ++i) EXPECT_GT(given[i], given[i - 1]) << i;
}

TEST(SceneStoreRestart, keeps_bytes_exactly_as_long_as_a_name_has_them) {
  const TemporaryFolder folder;
  const auto store = open_store(folder.path());
  ASSERT_TRUE(put_text(*store, "a", "same").ok());
  ASSERT_TRUE(put_text(*store, "b", "same").ok());
  ASSERT_TRUE(put_text(*store, "a", "same").ok());
  EXPECT_EQ(folder.files("blobs"), std::vector{hash("same")});
  ASSERT_TRUE(put_text(*store, "a", "other").ok());
  EXPECT_EQ(folder.files("blobs").size(), 2u);
  ASSERT_TRUE(store->remove("b").ok());
  EXPECT_EQ(folder.files("blobs"), std::vector{hash("other")});
  ASSERT_TRUE(store->remove("a").ok());
  EXPECT_TRUE(folder.files("blobs").empty());
  EXPECT_TRUE(folder.files("scenes").empty());
}

TEST(SceneStoreRestart, quarantines_what_is_damaged_and_starts_with_the_rest) {
  const TemporaryFolder folder;
  {
    const auto store = open_store(folder.path());
    for (const char* id : {"whole", "changed", "cut", "lost", "scrambled"}) {
      ASSERT_TRUE(put_text(*store, id, std::string("text of ") + id).ok());
    }
  }
  const fs::path blobs = folder.path() / "blobs";
  write_file(blobs / hash("text of changed"), "TEXT of changed");
  write_file(blobs / hash("text of cut"), "text");
  fs::remove(blobs / hash("text of lost"));
  write_file(folder.path() / "scenes/scrambled.json", "{\"id\":\"scram");
  {
    const auto store = open_settled(folder.path());
    EXPECT_EQ(text_of(*store, "whole"), "text of whole");
    for (const char* id : {"changed", "cut", "lost", "scrambled"}) {
      EXPECT_EQ(text_of(*store, id), "[failed]") << id;
      const Error& failure = *store->find(id)->failure;
      EXPECT_EQ(failure.code, "STORE_DAMAGED");
      EXPECT_NE(failure.message.find("quarantine"), std::string::npos) << failure.message;
      EXPECT_EQ(failure.message.find(folder.path().string()), std::string::npos);
    }
    EXPECT_EQ(folder.files("scenes"), std::vector<std::string>{"whole.json"});
    EXPECT_EQ(folder.files("quarantine").size(), 6u);
    // The name is free for new content, as it will be after the next start.
    for (const char* id : {"changed", "cut", "lost"}) {
      EXPECT_EQ(store->find(id)->etag, "") << id;
      EXPECT_FALSE(store->find(id)->persistent) << id;
    }
    ASSERT_TRUE(put_text(*store, "cut", "again").ok());
  }
  const auto store = open_settled(folder.path());
  EXPECT_EQ(text_of(*store, "whole"), "text of whole");
  EXPECT_EQ(text_of(*store, "cut"), "again");
  EXPECT_EQ(text_of(*store, "lost"), "[none]");
}

/// A scene is a text, and that of the file beside it.
Result<std::shared_ptr<const Scene>> load_with_neighbour(const LoadInput& input) {
  const auto beside = input.neighbour("beside");
  if (!beside) return beside.error();
  return load_text({*beside, input.choice, input.progress});
}

std::unique_ptr<SceneStore> open_with_neighbours(const fs::path& folder) {
  auto store = SceneStore::open({.folder = folder}, load_with_neighbour, {});
  EXPECT_TRUE(store.ok());
  wait_until_settled(**store);
  return std::move(*store);
}

void put_with_neighbour(SceneStore& store, const std::string& id, const std::string& beside) {
  auto incoming = send_text(store, id, "the same");
  incoming->find_neighbours([beside](const std::string&, const auto& sink) {
    return sink(std::as_bytes(std::span(beside.data(), beside.size())));
  });
  ASSERT_TRUE(store.wait(*store.submit(std::move(*incoming)), Deadline::never())->ok());
}

TEST(SceneStoreRestart, takes_nothing_from_others_but_the_file_that_is_damaged) {
  const TemporaryFolder folder;
  {
    const auto store = open_with_neighbours(folder.path());
    put_with_neighbour(*store, "a", "beside a");
    put_with_neighbour(*store, "b", "beside b");
  }
  write_file(folder.path() / "blobs" / hash("beside a"), "BESIDE a");
  // Twice: nor does the next start drop what the quarantined record names.
  for (int start = 0; start < 2; ++start) {
    const auto store = open_with_neighbours(folder.path());
    EXPECT_EQ(text_of(*store, "b"), "beside b");
    EXPECT_EQ(text_of(*store, "a"), start == 0 ? "[failed]" : "[none]");
    EXPECT_EQ(folder.files("quarantine"),
              (std::vector<std::string>{"a.json.0", hash("beside a") + ".0"}));
    EXPECT_EQ(folder.files("blobs").size(), 2u);
  }
  // With the right bytes and its record it is there again.
  write_file(folder.path() / "blobs" / hash("beside a"), "beside a");
  fs::rename(folder.path() / "quarantine/a.json.0", folder.path() / "scenes/a.json");
  EXPECT_EQ(text_of(*open_with_neighbours(folder.path()), "a"), "beside a");
}

// What a start finds damaged another scene may bring again before it is moved away.
TEST(SceneStoreRestart, moves_nothing_to_quarantine_that_is_good_again) {
  const TemporaryFolder folder;
  ASSERT_TRUE(put_text(*open_store(folder.path()), "a", "text").ok());
  const auto opened = SceneFolder::open(folder.path());
  ASSERT_TRUE(opened.ok());
  const auto catalogue = (*opened)->read_catalogue();
  ASSERT_TRUE(catalogue.ok());
  const SceneRecord& record = catalogue->records.at(0);
  const fs::path blob = folder.path() / "blobs" / record.sha256;
  const auto taken = (*opened)->quarantine(record, {record.sha256, record.bytes});
  ASSERT_TRUE(taken.ok());
  EXPECT_FALSE(*taken);
  EXPECT_TRUE(fs::exists(blob));
  EXPECT_EQ(folder.files("scenes"), std::vector<std::string>{"a.json"});
  write_file(blob, "TEXT");
  const auto moved = (*opened)->quarantine(record, {record.sha256, record.bytes});
  ASSERT_TRUE(moved.ok());
  EXPECT_TRUE(*moved);
  EXPECT_FALSE(fs::exists(blob));
  EXPECT_EQ(folder.files("quarantine").size(), 2u);
}

TEST(SceneStoreRestart, keeps_what_a_quarantined_record_may_name_until_a_person_removes_it) {
  for (const bool readable : {false, true}) {
    const TemporaryFolder folder;
    {
      const auto store = open_store(folder.path());
      for (const char* id : {"a", "b"}) ASSERT_TRUE(put_text(*store, id, id).ok());
    }
    if (readable) {
      write_file(folder.path() / "blobs" / hash("a"), "A");
    } else {
      write_file(folder.path() / "scenes/a.json", "{\"id\":\"a");
    }
    for (int start = 0; start < 3; ++start) {
      const auto store = open_settled(folder.path());
      EXPECT_EQ(folder.files(readable ? "quarantine" : "blobs").size(), 2u);
      // Only where one cannot tell what the record names does everything stay.
      if (start == 0) {
        ASSERT_TRUE(store->remove("b").ok());
      }
      EXPECT_EQ(fs::exists(folder.path() / "blobs" / hash("b")), !readable);
    }
    fs::remove(folder.path() / "quarantine/a.json.0");
    open_settled(folder.path());
    EXPECT_TRUE(folder.files("blobs").empty());
  }
}

TEST(SceneStoreRestart, loses_nothing_where_the_quarantine_takes_no_more) {
  for (const bool of_records : {false, true}) {
    const TemporaryFolder folder;
    {
      const auto store = open_store(folder.path());
      ASSERT_TRUE(put_text(*store, "a", "a").ok());
    }
    const fs::path blob = folder.path() / "blobs" / hash("a");
    const std::string name = of_records ? "a.json" : hash("a");
    write_file(blob, "A");
    for (int number = 0; number < 1000; ++number) {
      write_file(folder.path() / "quarantine" / (name + "." + std::to_string(number)), "");
    }
    const auto store = open_settled(folder.path());
    ASSERT_EQ(text_of(*store, "a"), "[failed]");
    const std::string message = store->find("a")->failure->message;
    EXPECT_NE(message.find("cannot move it to quarantine"), std::string::npos) << message;
    EXPECT_TRUE(fs::exists(blob));
    EXPECT_EQ(fs::exists(folder.path() / "scenes/a.json"), of_records);
  }
}

std::string read_file(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Makes the folder one of format 1, whose records have neither checksum nor fingerprint.
void make_older(const fs::path& folder) {
  for (const auto& each : fs::directory_iterator(folder / "scenes")) {
    std::string text = read_file(each);
    for (const char* key : {",\"fingerprint\":", ",\"checksum\":"}) {
      const std::size_t begin = text.find(key);
      ASSERT_NE(begin, std::string::npos) << text;
      text.erase(begin, text.find_first_of(",}", begin + 1) - begin);
    }
    write_file(each, text);
  }
  write_file(folder / "format", "sightline-store 1\n");
}

TEST(SceneStoreRestart, checks_by_sha256_what_an_older_version_recorded) {
  const TemporaryFolder folder;
  {
    const auto store = open_store(folder.path());
    for (const char* id : {"whole", "changed"}) ASSERT_TRUE(put_text(*store, id, id).ok());
  }
  make_older(folder.path());
  write_file(folder.path() / "blobs" / hash("changed"), "CHANGED");
  const auto store = open_settled(folder.path());
  EXPECT_EQ(text_of(*store, "whole"), "whole");
  EXPECT_EQ(text_of(*store, "changed"), "[failed]");
}

TEST(SceneStoreRestart, gives_the_records_of_an_older_version_their_checksum) {
  const TemporaryFolder folder;
  {
    const auto store = open_store(folder.path());
    ASSERT_TRUE(put_text(*store, "town", "houses").ok());
    ASSERT_TRUE(put_text(*store, "damaged", "d").ok());
  }
  make_older(folder.path());
  const fs::path damaged = folder.path() / "scenes/damaged.json";
  std::string text = read_file(damaged);
  text.replace(text.find("revision"), 8, "revisiom");
  write_file(damaged, text);
  const std::string older = read_file(folder.path() / "scenes/town.json");
  for (int start = 0; start < 2; ++start) {
    const auto store = open_settled(folder.path());
    EXPECT_EQ(text_of(*store, "town"), "houses");
    EXPECT_EQ(text_of(*store, "damaged"), start == 0 ? "[failed]" : "[none]");
    EXPECT_EQ(read_file(folder.path() / "format"), "sightline-store 2\n");
    EXPECT_NE(read_file(folder.path() / "scenes/town.json").find("checksum"), std::string::npos);
  }
  // From then on a record without one is damaged.
  write_file(folder.path() / "scenes/town.json", older);
  EXPECT_EQ(text_of(*open_settled(folder.path()), "town"), "[failed]");
}

TEST(SceneStoreRestart, serves_an_older_folder_that_it_cannot_upgrade) {
  const TemporaryFolder folder;
  {
    const auto store = open_store(folder.path());
    ASSERT_TRUE(put_text(*store, "town", "houses").ok());
  }
  make_older(folder.path());
  // A record that cannot be read now may be an older one at the next start.
  const fs::path unread = folder.path() / "scenes/unread.json";
  fs::create_symlink("unread.json", unread);
  {
    const auto store = open_settled(folder.path());
    EXPECT_EQ(text_of(*store, "town"), "houses");
    EXPECT_EQ(text_of(*store, "unread"), "[failed]");
    EXPECT_EQ(read_file(folder.path() / "format"), "sightline-store 1\n");
    ASSERT_TRUE(put_text(*store, "new", "newer").ok());
  }
  fs::remove(unread);
  const auto store = open_settled(folder.path());
  EXPECT_EQ(text_of(*store, "town"), "houses");
  EXPECT_EQ(text_of(*store, "new"), "newer");
  EXPECT_EQ(read_file(folder.path() / "format"), "sightline-store 2\n");
}

TEST(SceneStoreRestart, believes_the_sha256_where_a_fingerprint_is_another_one) {
  const TemporaryFolder folder;
  {
    const auto store = open_store(folder.path());
    ASSERT_TRUE(put_text(*store, "town", "houses").ok());
  }
  const fs::path file = folder.path() / "scenes/town.json";
  auto record = decode_record(read_file(file), "town", RecordForm::kChecked);
  ASSERT_TRUE(record && record->fingerprint);
  record->fingerprint = 7;
  write_file(file, encode_record(*record));
  EXPECT_EQ(text_of(*open_settled(folder.path()), "town"), "houses");
}

TEST(SceneStoreRestart, takes_no_record_that_lies_about_itself) {
  const TemporaryFolder folder;
  open_store(folder.path());
  // Where no checksum is demanded.
  write_file(folder.path() / "format", "sightline-store 1\n");
  const std::string sha = std::string(64, 'a');
  const std::string rest = R"(,"bytes":1,"revision":1,"scene":null})";
  const std::pair<const char*, std::string> records[] = {
      {"other_name", R"({"id":"x","sha256":")" + sha + "\"" + rest},
      {"bad_hash", R"({"id":"bad_hash","sha256":"../../etc/passwd")" + rest},
      {"no_hash", R"({"id":"no_hash")" + rest},
      {"array", "[]"},
      {"empty", ""},
      {"deep", std::string(60000, '[')},
      {"large", std::string(100000, ' ')},
      {"negative", R"({"id":"negative","sha256":")" + sha + R"(","bytes":-1,"revision":1})"},
  };
  for (const auto& [id, text] : records) {
    write_file(folder.path() / "scenes" / (std::string(id) + ".json"), text);
  }
  write_file(folder.path() / "scenes/.hidden.json", "{}");
  write_file(folder.path() / "scenes/readme.txt", "hello");
  const auto store = open_settled(folder.path());
  EXPECT_EQ(store->list().size(), std::size(records));
  for (const auto& [id, text] : records) EXPECT_EQ(text_of(*store, id), "[failed]") << id;
}

TEST(SceneStoreRestart, drops_what_a_crash_left_half_done) {
  const TemporaryFolder folder;
  {
    const auto store = open_store(folder.path());
    ASSERT_TRUE(put_text(*store, "town", "houses").ok());
  }
  write_file(folder.path() / "tmp/17", "half an upload");
  write_file(folder.path() / "blobs" / hash("no record"), "no record");
  const auto store = open_settled(folder.path());
  EXPECT_EQ(text_of(*store, "town"), "houses");
  EXPECT_TRUE(folder.files("tmp").empty());
  EXPECT_EQ(folder.files("blobs"), std::vector{hash("houses")});
}

TEST(SceneStoreRestart, keeps_a_file_that_the_loader_no_longer_takes) {
  const TemporaryFolder folder;
  {
    const auto store = open_store(folder.path());
    ASSERT_TRUE(put_text(*store, "town", "houses").ok());
  }
  {
    auto opened =
        SceneStore::open({.folder = folder.path(), .loads_at_once = 1},
                         [](const LoadInput&) -> Result<std::shared_ptr<const Scene>> {
                           return Error{ErrorKind::kTooLarge, "TOO_LARGE", "too large today", ""};
                         },
                         {});
    wait_until_settled(**opened);
    EXPECT_EQ(text_of(**opened, "town"), "[failed]");
  }
  EXPECT_EQ(text_of(*open_settled(folder.path()), "town"), "houses");
}

TEST(SceneStoreRestart, gives_an_acknowledged_scene_precedence_over_a_preload) {
  const TemporaryFolder folder;
  const auto make = [](Progress&) -> Result<PreloadedScene> {
    return PreloadedScene{text_scene("demo"), "00", "", 4};
  };
  {
    const auto store = open_settled(folder.path(), {{"town", make}});
    EXPECT_EQ(text_of(*store, "town"), "demo");
    EXPECT_FALSE(store->find("town")->persistent);
    ASSERT_TRUE(put_text(*store, "town", "mine").ok());
  }
  EXPECT_EQ(text_of(*open_settled(folder.path(), {{"town", make}}), "town"), "mine");
}

TEST(SceneStoreRestart, refuses_a_folder_that_another_server_uses) {
  const TemporaryFolder folder;
  const auto store = open_store(folder.path());
  const auto second =
      SceneStore::open({.folder = folder.path(), .loads_at_once = 1}, load_text, {});
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, "STORE_IN_USE");
}

TEST(SceneStoreRestart, refuses_a_folder_of_an_unknown_format_and_touches_nothing) {
  const TemporaryFolder folder;
  {
    const auto store = open_store(folder.path());
    ASSERT_TRUE(put_text(*store, "town", "houses").ok());
  }
  write_file(folder.path() / "format", "sightline-store 999\n");
  const auto second =
      SceneStore::open({.folder = folder.path(), .loads_at_once = 1}, load_text, {});
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, "STORE_FORMAT_UNKNOWN");
  EXPECT_EQ(folder.files("scenes").size(), 1u);
  EXPECT_EQ(folder.files("blobs").size(), 1u);
}

TEST(SceneStoreRestart, refuses_a_folder_of_somebody_else_and_touches_nothing) {
  for (const char* format : {"", "a note about paper formats\n"}) {
    const TemporaryFolder folder;
    fs::create_directories(folder.path() / "tmp");
    fs::create_directories(folder.path() / "scenes");
    write_file(folder.path() / "tmp" / "thesis.txt", "the only copy");
    write_file(folder.path() / "tmp" / "0", "a number");
    write_file(folder.path() / "scenes" / "town.json", "{}");
    if (*format != '\0') write_file(folder.path() / "format", format);
    const auto before = folder.files("");
    const auto store = SceneStore::open({.folder = folder.path()}, load_text, {});
    ASSERT_FALSE(store.ok());
    EXPECT_EQ(store.error().code, "STORE_FOREIGN");
    EXPECT_EQ(store.error().message.find(folder.path().string()), std::string::npos);
    EXPECT_EQ(folder.files(""), before);
    EXPECT_EQ(folder.files("tmp"), (std::vector<std::string>{"0", "thesis.txt"}));
    EXPECT_EQ(folder.files("scenes"), std::vector<std::string>{"town.json"});
  }
}

TEST(SceneStoreRestart, starts_again_where_it_was_stopped_before_it_wrote_its_format) {
  const TemporaryFolder folder;
  fs::create_directories(folder.path() / "lost+found");  // a file system's own
  write_file(folder.path() / "lock", "");
  write_file(folder.path() / "format.new", "sight");
  const auto store = open_store(folder.path());
  EXPECT_TRUE(put_text(*store, "town", "first").ok());
  EXPECT_FALSE(fs::exists(folder.path() / "format.new"));
}

TEST(SceneStoreRestart, deletes_only_its_own_temporary_files) {
  const TemporaryFolder folder;
  { const auto store = open_store(folder.path()); }
  write_file(folder.path() / "tmp" / "7", "half written");
  write_file(folder.path() / "tmp" / "x7", "not ours");
  write_file(folder.path() / "tmp" / "notes", "not ours");
  fs::create_directories(folder.path() / "tmp" / "8");
  const auto store = open_store(folder.path());
  EXPECT_EQ(folder.files("tmp"), (std::vector<std::string>{"8", "notes", "x7"}));
}

TEST(SceneStoreRestart, takes_what_cannot_be_read_for_no_damage) {
  const TemporaryFolder folder;
  const auto hash = [](std::string_view text) {
    return sha256_of(std::as_bytes(std::span(text.data(), text.size())));
  };
  {
    const auto store = open_store(folder.path());
    for (const char* id : {"whole", "record", "bytes"}) ASSERT_TRUE(put_text(*store, id, id).ok());
    ASSERT_TRUE(put_text(*store, "twin", "record").ok());
  }
  // Neither is a file that a process may read, and both will be there again.
  const fs::path record = folder.path() / "scenes/record.json";
  const fs::path bytes = folder.path() / "blobs" / hash("bytes");
  fs::rename(record, folder.path() / "kept record");
  fs::create_symlink("record.json", record);
  fs::rename(bytes, folder.path() / "kept bytes");
  fs::create_directory(bytes);
  {
    const auto store = open_settled(folder.path());
    EXPECT_EQ(text_of(*store, "whole"), "whole");
    for (const char* id : {"record", "bytes"}) {
      ASSERT_EQ(text_of(*store, id), "[failed]") << id;
      EXPECT_EQ(store->find(id)->failure->message.find("quarantine"), std::string::npos) << id;
    }
    EXPECT_EQ(store->find("record")->failure->code, "STORE_IO");
    EXPECT_TRUE(folder.files("quarantine").empty());
    // Who knows what the record names: nothing is dropped.
    ASSERT_TRUE(store->remove("twin").ok());
  }
  fs::remove(record);
  fs::rename(folder.path() / "kept record", record);
  fs::remove(bytes);
  fs::rename(folder.path() / "kept bytes", bytes);
  const auto store = open_settled(folder.path());
  for (const char* id : {"whole", "record", "bytes"}) EXPECT_EQ(text_of(*store, id), id);
}

TEST(SceneStoreRestart, refuses_to_start_where_it_cannot_tell_which_scenes_there_are) {
  const TemporaryFolder folder;
  {
    const auto store = open_store(folder.path());
    ASSERT_TRUE(put_text(*store, "town", "houses").ok());
  }
  const std::vector<std::string> blobs = folder.files("blobs");
  fs::rename(folder.path() / "scenes", folder.path() / "kept");
  fs::create_symlink("kept/town.json", folder.path() / "scenes");
  const auto store = SceneStore::open({.folder = folder.path(), .loads_at_once = 1}, load_text, {});
  EXPECT_FALSE(store.ok());
  EXPECT_EQ(folder.files("blobs"), blobs);
}

TEST(SceneStoreRestart, refuses_a_folder_that_cannot_be_made) {
  const TemporaryFolder folder;
  write_file(folder.path() / "file", "x");
  const auto store =
      SceneStore::open({.folder = folder.path() / "file/data", .loads_at_once = 1}, load_text, {});
  ASSERT_FALSE(store.ok());
  EXPECT_EQ(store.error().code, "STORE_IO");
}

}  // namespace
}  // namespace sightline
