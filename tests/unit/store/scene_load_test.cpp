#include <gtest/gtest.h>

#include <future>
#include <mutex>
#include <thread>

#include "tests/unit/store/text_scenes.h"

namespace sightline {
namespace {

/// A store with one thread whose loader waits in its stage "reading" until it is told to go on.
class SceneLoads : public testing::TestWithParam<bool> {
 protected:
  SceneLoads() { open(); }
  void open() {
    store_.reset();
    auto opened = SceneStore::open(
        {.folder = GetParam() ? folder_.path() : std::filesystem::path(),
         .loads_at_once = 1,
         .loads_max = 5,
         .report = [this](const std::string& id,
                          const Error& error) { reported_ += id + " " + error.code + "\n"; }},
        [this](const LoadInput& input) {
          input.progress.begin("reading", 8);
          input.progress.reach(2);
          {
            std::unique_lock hold(mutex_);
            ++begun_;
            changed_.notify_all();
            changed_.wait(hold, [&] { return open_ || input.progress.cancelled(); });
          }
          return load_text(input);
        },
        {});
    ASSERT_TRUE(opened.ok());
    store_ = std::move(*opened);
  }
  std::shared_ptr<SceneLoad> submit(const std::string& id, std::string_view text) {
    return store_->submit(std::move(*send_text(*store_, id, text)));
  }
  Result<Put> outcome(const std::shared_ptr<SceneLoad>& load) {
    return *store_->wait(*load, Deadline::never());
  }
  void wait_begun(int count) {
    std::unique_lock hold(mutex_);
    changed_.wait(hold, [&] { return begun_ >= count; });
  }
  void go_on() {
    const std::lock_guard hold(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  /// A cancelled loader looks at its flag only when it is woken.
  void wake() {
    const std::lock_guard hold(mutex_);
    changed_.notify_all();
  }
  static Deadline at_once() { return Deadline::in({}); }

  std::mutex mutex_;
  std::condition_variable changed_;
  int begun_ = 0;
  bool open_ = false;
  std::string reported_;
  TemporaryFolder folder_;
  std::unique_ptr<SceneStore> store_;
};
INSTANTIATE_TEST_SUITE_P(InMemoryAndInAFolder, SceneLoads, testing::Bool());

TEST_P(SceneLoads, tells_stage_and_percent_from_the_first_byte_to_the_last) {
  {
    auto incoming = store_->begin("town", {});
    ASSERT_TRUE(incoming.ok());
    incoming->expect(10);
    ASSERT_TRUE(incoming->append(std::as_bytes(std::span("house", 5))).ok());
    const SceneSnapshot scene = store_->find("town");
    EXPECT_EQ(scene->state, SceneState::kLoading);
    EXPECT_STREQ(scene->progress.stage, "receiving");
    EXPECT_EQ(scene->progress.percent, 50);
  }
  EXPECT_EQ(store_->find("town"), nullptr) << "what was not submitted has not happened";

  const auto first = submit("a", "x"), second = submit("b", "y");
  wait_begun(1);
  EXPECT_STREQ(store_->find("a")->progress.stage, "reading");
  EXPECT_EQ(store_->find("a")->progress.percent, 25);
  EXPECT_STREQ(store_->find("b")->progress.stage, "waiting");
  EXPECT_TRUE(store_->find("b")->is_moving());
  go_on();
  EXPECT_TRUE(outcome(first).ok());
  EXPECT_TRUE(outcome(second)->created);
  EXPECT_FALSE(store_->find("b")->is_moving());
  EXPECT_EQ(text_of(*store_, "b"), "y");
}

TEST_P(SceneLoads, shows_an_update_beside_the_content_that_is_still_served) {
  go_on();
  ASSERT_TRUE(put_text(*store_, "town", "old").ok());
  open_ = false;
  const auto load = submit("town", "new");
  wait_begun(2);
  const SceneSnapshot scene = store_->find("town");
  EXPECT_EQ(scene->state, SceneState::kReady);
  EXPECT_EQ(text_of(*store_, "town"), "old");
  ASSERT_TRUE(scene->update);
  EXPECT_EQ(scene->update->state, SceneState::kLoading);
  EXPECT_EQ(scene->update->progress.percent, 25);
  go_on();
  EXPECT_TRUE(outcome(load).ok());
  EXPECT_EQ(text_of(*store_, "town"), "new");
  EXPECT_FALSE(store_->find("town")->update);
}

TEST_P(SceneLoads, keeps_a_failure_that_nobody_waited_for) {
  const auto load = submit("town", "bad");
  wait_begun(1);
  EXPECT_FALSE(store_->wait(*load, at_once())) << "it is not over yet";
  go_on();
  while (store_->find("town")->is_moving()) std::this_thread::yield();
  EXPECT_EQ(store_->find("town")->state, SceneState::kFailed);
  EXPECT_EQ(store_->find("town")->failure->code, "TEXT_BAD");

  // Beside a content it is the update that has failed.
  ASSERT_TRUE(put_text(*store_, "town", "good").ok());
  EXPECT_FALSE(store_->find("town")->failure);
  const auto worse = submit("town", "bad");
  (void)store_->wait(*worse, at_once());
  while (store_->find("town")->is_moving()) std::this_thread::yield();
  EXPECT_EQ(text_of(*store_, "town"), "good");
  // The wait may have been told itself.
  if (const auto& update = store_->find("town")->update) {
    EXPECT_EQ(update->failure->code, "TEXT_BAD");
  }
  store_.reset();
  EXPECT_TRUE(reported_.starts_with("town TEXT_BAD\n")) << reported_;
}

TEST_P(SceneLoads, a_removal_cancels_in_every_stage) {
  // Waiting: the thread has another load.
  const auto busy = submit("busy", "x");
  wait_begun(1);
  const auto waiting = submit("town", "y");
  ASSERT_TRUE(store_->remove("town").ok());
  EXPECT_EQ(outcome(waiting).error().code, "LOAD_CANCELLED");
  EXPECT_EQ(store_->find("town"), nullptr);
  // Loading.
  ASSERT_TRUE(store_->remove("busy").ok());
  EXPECT_EQ(outcome(busy).error().code, "LOAD_CANCELLED");
  wake();
  // Receiving.
  auto incoming = store_->begin("town", {});
  ASSERT_TRUE(store_->remove("town").ok());
  EXPECT_EQ(incoming->append(std::as_bytes(std::span("x", 1))).error().code, "LOAD_CANCELLED");
  EXPECT_EQ(outcome(store_->submit(std::move(*incoming))).error().code, "LOAD_CANCELLED");
  EXPECT_EQ(store_->find("town"), nullptr);
  EXPECT_EQ(store_->remove("town").error().code, "SCENE_NOT_FOUND");
  // The name is free again, and nothing of the old time comes back.
  go_on();
  ASSERT_TRUE(put_text(*store_, "town", "new").ok());
  EXPECT_EQ(text_of(*store_, "town"), "new");
  if (GetParam()) {
    open();
    wait_until_settled(*store_);
    EXPECT_EQ(text_of(*store_, "town"), "new");
    EXPECT_EQ(store_->list().size(), 1u);
    EXPECT_EQ(folder_.files("blobs").size(), 1u);
    EXPECT_TRUE(folder_.files("tmp").empty());
  }
  EXPECT_EQ(reported_, "");
}

TEST_P(SceneLoads, what_began_last_stands_in_whatever_order_the_bytes_come) {
  go_on();
  auto first = send_text(*store_, "town", "first"), second = send_text(*store_, "town", "second"),
       third = send_text(*store_, "town", "third");
  const auto last = outcome(store_->submit(std::move(*third)));
  const auto earlier = outcome(store_->submit(std::move(*first)));
  const auto later = outcome(store_->submit(std::move(*second)));
  ASSERT_TRUE(last.ok() && earlier.ok() && later.ok());
  EXPECT_TRUE(last->created);
  EXPECT_EQ(text_of(*store_, "town"), "third");

  // Each is told of its own content, as if all had come in the order in which they began.
  EXPECT_EQ(earlier->scene->sha256, hash("first"));
  EXPECT_EQ(earlier->scene->etag, hash("first"));
  EXPECT_EQ(earlier->scene->state, SceneState::kReady);
  EXPECT_EQ(earlier->scene->scene->description().name, "first");
  EXPECT_EQ(later->scene->sha256, hash("second"));
  EXPECT_FALSE(earlier->created || later->created);
  EXPECT_EQ(earlier->scene->persistent, last->scene->persistent);
  EXPECT_LT(earlier->scene->revision, later->scene->revision);
  EXPECT_LT(later->scene->revision, last->scene->revision);
  EXPECT_EQ(store_->find("town")->revision, last->scene->revision);
  if (GetParam()) {
    EXPECT_EQ(folder_.files("blobs"), std::vector{hash("third")});
    EXPECT_TRUE(folder_.files("tmp").empty());
  }
}

TEST_P(SceneLoads, what_was_replaced_by_a_failure_is_not_overtaken) {
  go_on();
  auto first = send_text(*store_, "town", "first"), second = send_text(*store_, "town", "bad");
  EXPECT_FALSE(outcome(store_->submit(std::move(*second))).ok());
  const auto put = outcome(store_->submit(std::move(*first)));
  ASSERT_TRUE(put.ok());
  EXPECT_TRUE(put->created);
  EXPECT_EQ(text_of(*store_, "town"), "first");
}

TEST_P(SceneLoads, takes_only_so_many_at_once) {
  std::vector<std::shared_ptr<SceneLoad>> loads;
  for (const char* id : {"a", "b", "c", "d", "e"}) loads.push_back(submit(id, id));
  EXPECT_EQ(store_->begin("f", {}).error().code, "LOADS_TOO_MANY");
  go_on();
  for (auto& load : loads) {
    EXPECT_TRUE(outcome(load).ok());
    load.reset();
  }
  while (!store_->begin("f", {}).ok()) std::this_thread::yield();
}

TEST(LoadMemory, lets_the_files_of_one_load_exceed_the_limit_of_all) {
  const auto all = std::make_shared<UploadMemory>(1 << 20);
  const std::vector<std::byte> piece(3 << 19);
  {
    const auto first = std::make_shared<LoadMemory>(all);
    SceneUpload scene(first), beside(first);
    ASSERT_TRUE(scene.append(std::span(piece).first(1000)));
    EXPECT_TRUE(beside.append(piece));
    SceneUpload other(std::make_shared<LoadMemory>(all));
    EXPECT_EQ(other.append(std::span(piece).first(1)).error().code, "MEMORY_BUSY");
  }
  SceneUpload other(std::make_shared<LoadMemory>(all));
  EXPECT_TRUE(other.append(piece));
}

TEST_P(SceneLoads, ends_at_once_with_the_store) {
  const auto load = submit("town", "x");
  wait_begun(1);
  std::thread waker([&] {
    while (!load->progress().cancelled()) std::this_thread::yield();
    wake();
  });
  store_.reset();
  waker.join();
  EXPECT_EQ(reported_, "");
}

TEST_P(SceneLoads, wakes_who_waits_for_a_change) {
  const std::uint64_t seen = store_->changes();
  store_->wait_for_change(seen, at_once());
  EXPECT_EQ(store_->changes(), seen);
  auto waiter = std::async(std::launch::async, [&] {
    store_->wait_for_change(seen, Deadline::never());
    return store_->changes() != seen;
  });
  go_on();
  ASSERT_TRUE(put_text(*store_, "town", "x").ok());
  EXPECT_TRUE(waiter.get());
}

}  // namespace
}  // namespace sightline
