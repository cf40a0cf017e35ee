#include "core/store/scene_store.h"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <future>
#include <random>
#include <thread>

#include "core/store/sha256.h"
#include "tests/unit/store/text_scenes.h"

namespace sightline {
namespace {

TEST(SceneStore, gives_a_put_scene_back) {
  const auto store = open_store({});
  const auto put = put_text(*store, "town", "houses");
  ASSERT_TRUE(put.ok());
  EXPECT_TRUE(put->created);
  const SceneSnapshot scene = store->find("town");
  EXPECT_EQ(scene, put->scene);
  EXPECT_EQ(scene->state, SceneState::kReady);
  EXPECT_EQ(scene->revision, 1u);
  EXPECT_EQ(scene->bytes, 6u);
  EXPECT_EQ(scene->sha256, sha256_of(std::as_bytes(std::span("houses", 6))));
  EXPECT_FALSE(scene->persistent);
  EXPECT_EQ(scene->scene->description().name, "houses");
  EXPECT_EQ(store->find("Town"), nullptr);
}

TEST(SceneStore, replaces_a_scene_under_readers_who_keep_theirs) {
  const auto store = open_store({});
  ASSERT_TRUE(put_text(*store, "town", "old").ok());
  const SceneSnapshot old = store->find("town");
  const auto put = put_text(*store, "town", "new");
  ASSERT_TRUE(put.ok());
  EXPECT_FALSE(put->created);
  EXPECT_EQ(put->scene->revision, 2u);
  EXPECT_EQ(old->scene->description().name, "old");
  EXPECT_EQ(text_of(*store, "town"), "new");
}

TEST(SceneStore, counts_revisions_over_all_names_and_removals) {
  const auto store = open_store({});
  std::uint64_t last = 0;
  for (const char* id : {"a", "b", "a", "b"}) {
    const auto put = put_text(*store, id, "text");
    ASSERT_TRUE(put.ok());
    EXPECT_GT(put->scene->revision, last);
    last = put->scene->revision;
    ASSERT_TRUE(store->remove(id).ok());
  }
}

TEST(SceneStore, changes_nothing_when_a_put_fails) {
  for (const bool on_disk : {false, true}) {
    const TemporaryFolder folder;
    const auto store = open_store(on_disk ? folder.path() : "");
    EXPECT_EQ(put_text(*store, "town", "bad").error().code, "TEXT_BAD");
    EXPECT_EQ(store->find("town"), nullptr);
    ASSERT_TRUE(put_text(*store, "town", "good").ok());
    EXPECT_EQ(put_text(*store, "town", "bad").error().code, "TEXT_BAD");
    EXPECT_EQ(text_of(*store, "town"), "good");
    EXPECT_EQ(store->find("town")->revision, 1u);
    EXPECT_TRUE(!on_disk || folder.files("tmp").empty());
  }
}

TEST(SceneStore, lets_no_exception_of_the_loader_out_and_nothing_of_its_text) {
  const auto store = open_store({});
  const auto put = put_text(*store, "town", "throw");
  ASSERT_FALSE(put.ok());
  EXPECT_EQ(put.error().code, "SCENE_LOAD_FAILED");
  EXPECT_EQ(put.error().message.find("secret"), std::string::npos);
}

TEST(SceneStore, refuses_names_that_are_not_names) {
  const auto store = open_store({});
  EXPECT_EQ(put_text(*store, "../town", "x").error().code, "SCENE_ID_INVALID");
  auto opened = SceneStore::open({}, load_text, {{"", [](Progress&) { return PreloadedScene{}; }}});
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, "SCENE_ID_INVALID");
}

TEST(SceneStore, takes_a_content_in_the_place_of_that_which_is_named) {
  for (const bool on_disk : {false, true}) {
    const TemporaryFolder folder;
    const auto store = open_store(on_disk ? folder.path() : "");
    const auto put_if = [&](std::string_view text, const Precondition& precondition) {
      auto incoming = send_text(*store, "a", text);
      incoming->demand(precondition);
      const auto put = *store->wait(*store->submit(std::move(*incoming)), Deadline::never());
      return put ? "" : put.error().code;
    };
    const Precondition none{{}, TagList{true, {}}}, any{TagList{true, {}}, {}};
    const auto is = [](std::string_view text) {
      return Precondition{TagList{false, {hash("x"), hash(text)}}, {}};
    };
    EXPECT_EQ(put_if("first", any), "PRECONDITION_FAILED");
    EXPECT_EQ(text_of(*store, "a"), "[none]");
    EXPECT_EQ(put_if("first", none), "");
    EXPECT_EQ(put_if("second", none), "PRECONDITION_FAILED");
    EXPECT_EQ(put_if("second", is("second")), "PRECONDITION_FAILED");
    EXPECT_EQ(text_of(*store, "a"), "first");
    EXPECT_EQ(put_if("second", is("first")), "");
    EXPECT_EQ(put_if("third", any), "");
    EXPECT_EQ(store->remove("a", is("second")).error().code, "PRECONDITION_FAILED");
    EXPECT_EQ(store->remove("b", any).error().code, "SCENE_NOT_FOUND");
    EXPECT_EQ(text_of(*store, "a"), "third");
    EXPECT_TRUE(store->remove("a", is("third")).ok());
  }
}

TEST(SceneStore, of_two_for_the_same_content_one_is_too_late_whichever_ends_first) {
  for (const bool in_order : {false, true}) {
    const auto store = open_store({});
    ASSERT_TRUE(put_text(*store, "a", "before").ok());
    const Precondition precondition{TagList{false, {hash("before")}}, {}};
    auto first = send_text(*store, "a", "first"), second = send_text(*store, "a", "second");
    first->demand(precondition);
    second->demand(precondition);
    const auto submit = [&](Result<IncomingScene>& incoming) {
      return store->wait(*store->submit(std::move(*incoming)), Deadline::never())->ok();
    };
    EXPECT_TRUE(submit(in_order ? first : second));
    EXPECT_FALSE(submit(in_order ? second : first));
    EXPECT_EQ(text_of(*store, "a"), in_order ? "first" : "second");
  }
}

TEST(SceneStore, lists_by_name_and_forgets_what_is_removed) {
  const auto store = open_store({});
  for (const char* id : {"b", "c", "a"}) ASSERT_TRUE(put_text(*store, id, id).ok());
  ASSERT_TRUE(store->remove("b").ok());
  std::string ids;
  for (const SceneSnapshot& scene : store->list()) ids += scene->id;
  EXPECT_EQ(ids, "ac");
  EXPECT_EQ(store->remove("b").error().code, "SCENE_NOT_FOUND");
  EXPECT_EQ(store->remove("../a").error().code, "SCENE_NOT_FOUND");
}

TEST(SceneStore, shows_a_scene_that_is_on_its_way_as_loading) {
  std::promise<void> begun, may_end;
  auto opened = SceneStore::open({},
                                 [&](const LoadInput& input) {
                                   begun.set_value();
                                   may_end.get_future().wait();
                                   return load_text(input);
                                 },
                                 {});
  SceneStore& store = **opened;
  auto put = std::async(std::launch::async, [&] { return put_text(store, "town", "slow"); });
  begun.get_future().wait();
  EXPECT_EQ(text_of(store, "town"), "[loading]");
  may_end.set_value();
  EXPECT_TRUE(put.get().ok());
  EXPECT_EQ(text_of(store, "town"), "slow");
}

TEST(SceneStore, loads_no_more_at_once_than_it_may) {
  std::atomic<int> now{0}, most{0};
  auto opened =
      SceneStore::open({.folder = {}, .loads_at_once = 2},
                       [&](const LoadInput& input) {
                         const int count = ++now;
                         int seen = most;
                         while (count > seen && !most.compare_exchange_weak(seen, count)) {
                         }
                         for (int i = 0; i < 100; ++i) std::this_thread::yield();
                         --now;
                         return load_text(input);
                       },
                       {});
  std::vector<std::thread> threads;
  threads.reserve(6);
  for (int i = 0; i < 6; ++i) {
    threads.emplace_back([&, i] { EXPECT_TRUE(put_text(**opened, std::to_string(i), "x").ok()); });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_LE(most, 2);
}

TEST(SceneStore, loads_preloads_in_the_background_and_survives_a_bad_one) {
  std::promise<void> may_end;
  const auto make = [&](Progress&) -> Result<PreloadedScene> {
    may_end.get_future().wait();
    return PreloadedScene{text_scene("demo"), "00", "", 4};
  };
  const auto fail = [](Progress&) -> Result<PreloadedScene> {
    return Error{ErrorKind::kInvalid, "TEXT_BAD", "this text is bad", ""};
  };
  const auto store = open_store({}, {{"demo", make}, {"broken", fail}, {"demo", fail}});
  EXPECT_FALSE(store->settled());
  EXPECT_NE(text_of(*store, "demo"), "demo");
  may_end.set_value();
  wait_until_settled(*store);
  EXPECT_EQ(text_of(*store, "demo"), "demo");
  EXPECT_EQ(text_of(*store, "broken"), "[failed]");
  EXPECT_EQ(store->find("broken")->failure->code, "TEXT_BAD");
  // A failed scene can be replaced and removed.
  EXPECT_TRUE(put_text(*store, "broken", "mended").ok());
  EXPECT_EQ(text_of(*store, "broken"), "mended");
}

TEST(SceneStore, reports_a_full_disk_and_loses_nothing) {
  // Every write to this device fails for lack of space.
  SceneUpload upload(TemporaryFile(FileDescriptor(::open("/dev/full", O_WRONLY | O_CLOEXEC)), {}));
  const Status status = upload.append(std::as_bytes(std::span("houses", 6)));
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().kind, ErrorKind::kOutOfSpace);
  EXPECT_EQ(status.error().code, "STORE_FULL");
}

TEST(SceneStore, stays_whole_under_puts_removals_and_readers_at_once) {
  constexpr unsigned kSeed = 11;
  const TemporaryFolder folder;
  std::vector<std::string> end(3);
  {
    const auto store = open_store(folder.path());
    std::atomic<bool> done{false};
    std::thread reader([&] {
      while (!done) {
        for (const SceneSnapshot& scene : store->list()) {
          if (scene->state != SceneState::kReady) continue;
          EXPECT_EQ(scene->sha256,
                    sha256_of(std::as_bytes(std::span(scene->scene->description().name))));
        }
      }
    });
    std::vector<std::thread> writers;
    for (unsigned w = 0; w < 3; ++w) {
      writers.emplace_back([&, w] {
        std::mt19937 random(kSeed + w);
        for (int i = 0; i < 40; ++i) {
          const std::string id(1, static_cast<char>('a' + random() % 3));
          if (random() % 4 == 0) {
            (void)store->remove(id);
          } else {
            // Few texts, so that names share bytes.
            const auto put = put_text(*store, id, "text " + std::to_string(random() % 4));
            // Another writer may remove the name under it.
            EXPECT_TRUE(put.ok() || put.error().code == "LOAD_CANCELLED");
          }
        }
      });
    }
    for (std::thread& writer : writers) writer.join();
    done = true;
    reader.join();
    for (std::size_t i = 0; i < 3; ++i)
      end[i] = text_of(*store, std::string(1, static_cast<char>('a' + i)));
  }
  const auto store = open_settled(folder.path());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(text_of(*store, std::string(1, static_cast<char>('a' + i))), end[i]);
  }
}

}  // namespace
}  // namespace sightline
