#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <functional>
#include <latch>
#include <thread>
#include <vector>

#include "core/store/origin_folder.h"
#include "core/store/origin_scenes.h"
#include "core/store/scene_store.h"
#include "tests/unit/store/text_scenes.h"

namespace sightline {
namespace {

std::shared_ptr<Origin> open_origin(const TemporaryFolder& folder) {
  auto origin = OriginFolder::open(folder.path());
  if (!origin) {
    ADD_FAILURE() << origin.error().message;
    return nullptr;
  }
  return std::move(*origin);
}

/// An origin that can be made to fail, and that may overwrite objects as a careless store does.
class TroubledOrigin final : public Origin {
 public:
  explicit TroubledOrigin(std::shared_ptr<Origin> origin) : origin_(std::move(origin)) {}
  Result<bool> create(const std::string& name, std::string_view content) override {
    if (is_down) return down();
    if (overwrites) {
      if (Status status = origin_->remove(name); !status) return std::move(status).error();
    }
    return origin_->create(name, content);
  }
  Result<bool> create(const std::string& name, const FileDescriptor& file,
                      std::uint64_t bytes) override {
    if (is_down) return down();
    return origin_->create(name, file, bytes);
  }
  Result<bool> read(const std::string& name,
                    const std::function<Status(std::span<const std::byte>)>& sink) override {
    if (is_down) return down();
    ++reads;
    if (before_read) before_read();
    return origin_->read(name, sink);
  }
  Result<std::vector<OriginObject>> list(const std::string& prefix,
                                         const std::string& after) override {
    if (is_down) return down();
    auto listed = origin_->list(prefix, after);
    if (after_list) after_list();
    if (prefix == "names/") ++looks;
    return listed;
  }
  Status remove(const std::string& name) override { return origin_->remove(name); }

  std::atomic<bool> is_down{false}, overwrites{false};
  std::atomic<int> reads{0};
  std::atomic<int> looks{0};  ///< lists of all names, which a store makes by itself
  std::function<void()> before_read, after_list;  ///< to be set while no other thread calls

 private:
  static Error down() { return {ErrorKind::kBusy, "ORIGIN_UNREACHABLE", "down", ""}; }
  const std::shared_ptr<Origin> origin_;
};

/// A store with its data folder, as one of several servers.
struct Replica {
  TemporaryFolder folder;
  std::unique_ptr<SceneStore> store;

  explicit Replica(const std::shared_ptr<Origin>& origin, std::uint64_t cache_bytes = 0) {
    open(origin, cache_bytes);
  }
  /// Later looks at the origin are so far apart that the tests say when.
  void open(const std::shared_ptr<Origin>& origin, std::uint64_t cache_bytes = 0,
            std::chrono::milliseconds refresh = std::chrono::hours(1)) {
    StoreOptions options{.folder = folder.path()};
    options.shared = {std::make_shared<OriginScenes>(origin), "test", refresh, cache_bytes,
                      [](const std::string&) {}};
    auto opened = SceneStore::open(options, load_text, {});
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    store = std::move(*opened);
    wait_until_settled(*store);
  }
  /// The text of the scene as a request sees it; else the error's code, or "[none]".
  std::string text(const std::string& id, std::uint64_t minimum = 0) const {
    const auto scene = store->obtain(id, minimum, Deadline::never());
    if (!scene) return scene.error().code;
    if (!*scene) return "[none]";
    return text_of(*store, id);
  }
};

TEST(OriginFolder, creates_an_object_once) {
  const TemporaryFolder folder;
  const auto origin = open_origin(folder);
  for (int round = 0; round < 50; ++round) {
    const std::string name = "names/a/" + std::to_string(round);
    std::atomic<int> winners{0};
    std::vector<std::thread> writers;
    writers.reserve(4);
    for (int writer = 0; writer < 4; ++writer) {
      writers.emplace_back([&, writer] {
        const auto created = origin->create(name, std::to_string(writer));
        if (created && *created) ++winners;
      });
    }
    for (std::thread& writer : writers) writer.join();
    EXPECT_EQ(winners, 1);
  }
  const auto listed = origin->list("names/a/", "names/a/48");
  ASSERT_TRUE(listed.ok());
  std::vector<std::string> names;
  for (const OriginObject& object : *listed) names.push_back(object.name);
  const std::vector<std::string> expected{"names/a/49", "names/a/5", "names/a/6",
                                          "names/a/7",  "names/a/8", "names/a/9"};
  EXPECT_EQ(names, expected);
  EXPECT_TRUE(folder.files("writing").empty());
  EXPECT_TRUE(origin->list("nothing/", "").value().empty());
  EXPECT_FALSE(origin->read("nothing", [](auto) { return success(); }).value());
}

TEST(OriginScenes, refuses_to_write_to_an_origin_that_overwrites) {
  const TemporaryFolder folder;
  const auto origin = std::make_shared<TroubledOrigin>(open_origin(folder));
  origin->overwrites = true;
  OriginScenes scenes(origin);
  EXPECT_EQ(scenes.probe().error().code, "ORIGIN_UNSAFE");
  SceneRecord record{"town", hash("x"), 1, 1, {}};
  EXPECT_EQ(scenes.publish(record).error().code, "ORIGIN_UNSAFE");
  EXPECT_EQ(scenes.newest("town")->number, 0u);
  origin->overwrites = false;
  EXPECT_TRUE(scenes.publish(record).value());
  EXPECT_FALSE(scenes.publish(record).value());
  EXPECT_EQ(scenes.newest("town")->number, 1u);
  EXPECT_TRUE(folder.files("probe").empty());
}

TEST(OriginScenes, tells_damaged_records) {
  const TemporaryFolder folder;
  OriginScenes scenes(open_origin(folder));
  SceneRecord record{"town", hash("x"), 1, 1, {}};
  ASSERT_TRUE(scenes.publish(record).value());
  EXPECT_EQ(scenes.read_record("town", 1)->sha256, hash("x"));
  EXPECT_EQ(scenes.read_record("town", 2).error().code, "ORIGIN_DAMAGED");
  const auto path = folder.path() / "names/town/0000000000000001";
  std::fstream file(path);
  file.seekp(20);
  file.put('~');
  file.close();
  EXPECT_EQ(scenes.read_record("town", 1).error().code, "ORIGIN_DAMAGED");
}

TEST(SharedStore, another_store_has_what_one_has_put_changed_and_removed) {
  const TemporaryFolder shared;
  const auto origin = open_origin(shared);
  const Replica a(origin), b(origin);
  EXPECT_EQ(b.text("town"), "[none]");
  const auto put = put_text(*a.store, "town", "one");
  ASSERT_TRUE(put.ok()) << put.error().message;
  EXPECT_TRUE(put->created);
  EXPECT_EQ(put->scene->revision, 1u);
  EXPECT_EQ(b.text("town", 1), "one");
  EXPECT_EQ(b.store->find("town")->etag, put->scene->etag);
  EXPECT_EQ(b.store->find("town")->revision, 1u);

  const auto again = put_text(*b.store, "town", "two");
  ASSERT_TRUE(again.ok());
  EXPECT_FALSE(again->created);
  EXPECT_EQ(again->scene->revision, 2u);
  EXPECT_EQ(a.text("town"), "one");  // it may be old
  EXPECT_EQ(a.text("town", 2), "two");
  EXPECT_EQ(a.text("town", 3), "REVISION_UNKNOWN");

  ASSERT_TRUE(a.store->remove("town").ok());
  EXPECT_EQ(b.text("town", 3), "[none]");
  EXPECT_EQ(b.store->remove("town").error().code, "SCENE_NOT_FOUND");
  // Numbers go on after a removal.
  const auto third = put_text(*b.store, "town", "three");
  EXPECT_TRUE(third->created);
  EXPECT_EQ(third->scene->revision, 4u);
}

TEST(SharedStore, goes_on_with_a_load_when_it_hears_of_an_earlier_removal) {
  const TemporaryFolder shared;
  const auto folder = open_origin(shared);
  const auto origin = std::make_shared<TroubledOrigin>(folder);
  const Replica a(folder), b(origin);
  ASSERT_TRUE(put_text(*a.store, "town", "one").ok());
  ASSERT_TRUE(a.store->remove("town").ok());
  while (origin->looks == 0) std::this_thread::yield();  // b does so once, at its start
  std::latch has_listed{1}, is_loading{1}, may_drop{1}, may_load{1};
  std::atomic<int> lists{0};
  origin->after_list = [&] {
    if (++lists > 1) return;
    has_listed.count_down();
    may_drop.wait();
  };
  std::atomic<int> loads{0};
  origin->before_read = [&] {
    if (++loads > 1) return;
    is_loading.count_down();
    may_load.wait();
  };
  std::thread late([&] { EXPECT_EQ(b.text("town", 2), "[loading]"); });
  has_listed.wait();  // this thread knows of the removal, and not of what follows
  ASSERT_TRUE(put_text(*a.store, "town", "two").ok());
  std::thread reader([&] { EXPECT_EQ(b.text("town", 3), "two"); });
  is_loading.wait();
  may_drop.count_down();
  late.join();
  may_load.count_down();
  reader.join();
}

TEST(SharedStore, checks_preconditions_against_the_origin) {
  const TemporaryFolder shared;
  const auto origin = open_origin(shared);
  const Replica a(origin), b(origin);
  ASSERT_TRUE(put_text(*a.store, "town", "one").ok());
  const auto put_if = [&](const Replica& replica, const Precondition& precondition) {
    auto incoming = send_text(*replica.store, "town", "two");
    incoming->demand(precondition);
    const auto put =
        *replica.store->wait(*replica.store->submit(std::move(*incoming)), Deadline::never());
    return put.ok() ? std::string("ok") : put.error().code;
  };
  const TagList any{true, {}};
  EXPECT_EQ(put_if(b, {{}, any}), "PRECONDITION_FAILED");  // b has never seen the scene
  EXPECT_EQ(put_if(b, {TagList{false, {hash("other")}}, {}}), "PRECONDITION_FAILED");
  EXPECT_EQ(put_if(b, {TagList{false, {hash("one")}}, {}}), "ok");
  EXPECT_EQ(put_if(a, {TagList{false, {hash("one")}}, {}}), "PRECONDITION_FAILED");
  EXPECT_EQ(a.store->remove("town", {TagList{false, {hash("one")}}, {}}).error().code,
            "PRECONDITION_FAILED");
  EXPECT_TRUE(a.store->remove("town", {TagList{false, {hash("two")}}, {}}).ok());
}

TEST(SharedStore, loses_no_change_of_several_writers) {
  const TemporaryFolder shared;
  const auto origin = open_origin(shared);
  const Replica a(origin), b(origin), c(origin);
  constexpr int kEach = 20;
  std::atomic<int> done{0};
  std::vector<std::thread> writers;
  for (const Replica* replica : {&a, &b, &c}) {
    writers.emplace_back([&, replica] {
      for (int i = 0; i < kEach; ++i) {
        const auto put = put_text(*replica->store, "town", std::to_string(i));
        if (put.ok()) ++done;
      }
    });
  }
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(done, 3 * kEach);
  EXPECT_EQ(OriginScenes(origin).newest("town")->number, 3u * kEach);
}

TEST(SharedStore, starts_from_its_cache_and_follows_what_changed_meanwhile) {
  const TemporaryFolder shared;
  const auto origin = std::make_shared<TroubledOrigin>(open_origin(shared));
  Replica a(origin), b(origin);
  ASSERT_TRUE(put_text(*a.store, "town", "one").ok());
  EXPECT_EQ(b.text("town"), "one");
  b.store.reset();
  ASSERT_TRUE(put_text(*a.store, "town", "two").ok());
  origin->is_down = true;
  b.open(origin);
  EXPECT_EQ(b.text("town"), "one");
  EXPECT_EQ(b.text("town", 2), "ORIGIN_UNREACHABLE");
  EXPECT_EQ(b.text("other"), "ORIGIN_UNREACHABLE");
  EXPECT_EQ(put_text(*b.store, "town", "x").error().code, "ORIGIN_UNREACHABLE");
  EXPECT_EQ(b.store->remove("town").error().code, "ORIGIN_UNREACHABLE");
  EXPECT_EQ(b.text("town"), "one");
  origin->is_down = false;
  // For a moment it is not asked again.
  while (b.text("town", 2) == "ORIGIN_UNREACHABLE") std::this_thread::yield();
  EXPECT_EQ(b.text("town", 2), "two");
}

TEST(SharedStore, looks_at_the_origin_by_itself) {
  const TemporaryFolder shared;
  const auto origin = open_origin(shared);
  const Replica a(origin);
  ASSERT_TRUE(put_text(*a.store, "town", "one").ok());
  Replica b(origin);
  EXPECT_EQ(b.text("town"), "one");
  ASSERT_TRUE(put_text(*a.store, "town", "two").ok());
  ASSERT_TRUE(put_text(*a.store, "house", "three").ok());
  b.store.reset();
  b.open(origin);  // it looks once at its start
  while (text_of(*b.store, "town") != "two") std::this_thread::yield();
  const auto listed = b.store->list();
  ASSERT_EQ(listed.size(), 2u);
  EXPECT_EQ(listed[0]->id, "house");
  EXPECT_EQ(listed[0]->state, SceneState::kStored);
  EXPECT_EQ(b.text("house"), "three");
}

TEST(SharedStore, keeps_no_more_than_its_cache_may_hold) {
  const TemporaryFolder shared;
  const auto origin = open_origin(shared);
  const Replica a(origin);
  for (const char* id : {"a", "b", "c"}) ASSERT_TRUE(put_text(*a.store, id, "four").ok());
  const Replica b(origin, 8);
  EXPECT_EQ(b.text("a"), "four");
  EXPECT_EQ(b.text("b"), "four");
  EXPECT_EQ(b.text("a"), "four");  // used later than b
  EXPECT_EQ(b.text("c"), "four");
  EXPECT_EQ(text_of(*b.store, "b"), "[none]");
  EXPECT_EQ(text_of(*b.store, "a"), "four");
  EXPECT_EQ(b.folder.files("scenes").size(), 2u);
  EXPECT_EQ(b.text("b"), "four");
}

TEST(SharedStore, fetches_again_what_is_damaged_here) {
  const TemporaryFolder shared;
  const auto origin = open_origin(shared);
  Replica a(origin);
  ASSERT_TRUE(put_text(*a.store, "town", "one").ok());
  a.store.reset();
  { std::ofstream(a.folder.path() / "blobs" / hash("one")) << "two"; }
  a.open(origin);
  EXPECT_EQ(a.text("town"), "one");
  a.store.reset();
  { std::ofstream(a.folder.path() / "scenes/town.json") << "{"; }
  a.open(origin);
  EXPECT_EQ(a.text("town"), "one");
  // A new record of bytes that are damaged here.
  Replica b(origin);
  EXPECT_EQ(b.text("town"), "one");
  ASSERT_TRUE(put_text(*a.store, "town", "one").ok());
  { std::ofstream(b.folder.path() / "blobs" / hash("one")) << "two"; }
  EXPECT_EQ(b.text("town", 2), "one");
  for (const Replica* each : {&a, &b}) {
    EXPECT_TRUE(each->folder.files("quarantine").empty());
    EXPECT_EQ(each->folder.files("blobs").size(), 1u);
  }
}

TEST(SharedStore, fetches_again_by_itself_what_a_start_finds_damaged) {
  const TemporaryFolder shared;
  const auto origin = open_origin(shared);
  Replica a(origin);
  ASSERT_TRUE(put_text(*a.store, "town", "one").ok());
  a.store.reset();
  std::filesystem::remove(a.folder.path() / "blobs" / hash("one"));
  a.open(origin, 0, std::chrono::milliseconds(10));
  while (text_of(*a.store, "town") != "one") std::this_thread::yield();
}

TEST(SharedStore, takes_nothing_that_is_damaged_there) {
  const TemporaryFolder shared;
  const auto origin = open_origin(shared);
  const Replica a(origin), b(origin);
  ASSERT_TRUE(put_text(*a.store, "town", "one").ok());
  for (const char* other : {"two", "on", "one and more", ""}) {
    { std::ofstream(shared.path() / "blobs" / hash("one")) << other; }
    EXPECT_EQ(b.text("town"), "ORIGIN_DAMAGED") << other;
    EXPECT_TRUE(b.folder.files("blobs").empty());
  }
  std::filesystem::remove(shared.path() / "blobs" / hash("one"));
  EXPECT_EQ(b.text("town"), "ORIGIN_DAMAGED");
  EXPECT_EQ(a.text("town"), "one");
}

TEST(SharedStore, takes_no_folder_of_another_kind) {
  const TemporaryFolder own, first;
  const auto origin = open_origin(first);
  {
    const auto store = open_settled(own.path());
    ASSERT_TRUE(put_text(*store, "town", "one").ok());
  }
  StoreOptions options{.folder = own.path()};
  options.shared = {std::make_shared<OriginScenes>(origin), "test", std::chrono::hours(1), 0,
                    [](const std::string&) {}};
  EXPECT_EQ(SceneStore::open(options, load_text, {}).error().code, "STORE_IS_CACHE");
  Replica replica(origin);
  replica.store.reset();
  options.folder = replica.folder.path();
  options.shared.name = "another";
  EXPECT_EQ(SceneStore::open(options, load_text, {}).error().code, "STORE_IS_CACHE");
  options.shared = {};
  EXPECT_EQ(SceneStore::open(options, load_text, {}).error().code, "STORE_IS_CACHE");
}

}  // namespace
}  // namespace sightline
