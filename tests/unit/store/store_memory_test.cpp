// What a store takes of memory, and what it does without; in a program of its own, because it
// replaces the allocator.

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <new>
#include <thread>
#include <utility>

#include "core/demo/demo.h"
#include "core/import/import.h"
#include "core/store/posix_file.h"
#include "core/store/tree_cache_manager.h"
#include "tests/unit/store/text_scenes.h"

namespace {

/// How many more allocations of this thread are granted before one is refused; negative: all.
thread_local long granted = -1;
/// The same of all other threads, from which on each is refused; and how many were.
std::atomic<long> granted_elsewhere{-1};
std::atomic<long> refused_elsewhere{0};
thread_local bool is_test = false;
std::atomic<std::size_t> largest{0};  ///< of the bytes that were asked for at once
std::atomic<long> living{0};          ///< allocations that were not given back

void* allocate(std::size_t size, std::size_t alignment) {
  std::size_t seen = largest;
  while (size > seen && !largest.compare_exchange_weak(seen, size)) {
  }
  if (!is_test && granted_elsewhere >= 0 && (granted_elsewhere == 0 || --granted_elsewhere < 0)) {
    ++refused_elsewhere;
    throw std::bad_alloc();
  }
  void* memory = nullptr;
  if ((granted >= 0 && granted-- == 0) ||
      ::posix_memalign(&memory, alignment, size == 0 ? 1 : size) != 0) {
    throw std::bad_alloc();
  }
  ++living;
  return memory;
}

void give_back(void* memory) noexcept {
  if (memory != nullptr) --living;
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
// Not inline: a compiler that sees new end in free without seeing this new calls it a mismatch.
[[gnu::noinline]] void operator delete(void* memory) noexcept { give_back(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { give_back(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  give_back(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  give_back(memory);
}

namespace sightline {
namespace {

/// Calls ask() with its first allocation on this thread refused, then its second, ... until it
/// makes no more. ask() may throw.
template <class Ask>
void with_every_failure(const Ask& ask) {
  for (long grant = 0; grant < 10000; ++grant) {
    granted = grant;
    bool thrown = false;
    try {
      ask();
    } catch (const std::bad_alloc&) {
      thrown = true;
    }
    const bool refused = granted < 0;
    granted = -1;
    if (!refused && !thrown) return;
  }
  FAIL();
}

TEST(StoreMemory, no_load_is_on_its_way_for_ever_whichever_allocation_fails) {
  const auto store = open_store({});
  const auto expect_end = [&] {
    const auto is_on_its_way = [&] {
      const SceneSnapshot scene = store->find("a");
      return scene && scene->is_moving();
    };
    const Deadline deadline = Deadline::in(std::chrono::seconds(20));
    while (is_on_its_way() && !deadline.passed()) std::this_thread::yield();
    return !is_on_its_way();
  };
  bool ended = true;
  with_every_failure([&] {
    const long grant = std::exchange(granted, -1);
    ended = ended && expect_end();
    auto incoming = send_text(*store, "a", "text");
    granted = grant;
    store->submit(std::move(*incoming), false);
  });
  EXPECT_TRUE(ended && expect_end());
  with_every_failure([&] {
    const long grant = std::exchange(granted, -1);
    ended = ended && expect_end();
    // Too large to stand in a std::function: the job takes memory for it.
    const std::array<char, 64> large{};
    SceneFetch source = [large](IncomingScene& incoming) {
      return incoming.append(std::as_bytes(std::span(large)));
    };
    granted = grant;
    (void)store->fetch("a", {}, std::move(source), false);
  });
  EXPECT_TRUE(ended && expect_end());
}

TEST(StoreMemory, a_small_record_takes_little_memory_to_read) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "text") << "small";
  largest = 0;
  EXPECT_EQ(*read_small_file(folder.path() / "text", kRecordLimit, "read it"), "small");
  EXPECT_LE(largest, 1u << 16);
}

TEST(StoreMemory, a_keeper_goes_on_whichever_allocation_of_its_thread_fails) {
  is_test = true;
  for (long grant = 0; grant < 12; ++grant) {
    TreeCacheOptions options;
    options.report = [](const std::string&) {};
    TreeCacheManager manager(options);
    const auto scene = *Scene::prepare(*import_bytes(demo::write_glb(demo::terrain(300, 1)), {}));
    refused_elsewhere = 0;
    granted_elsewhere = grant;
    ASSERT_TRUE(manager.adopt(scene));
    // What is refused first, and then either the line about it or the next look.
    const Deadline deadline = Deadline::in(std::chrono::seconds(20));
    while (refused_elsewhere < 2 && !deadline.passed()) std::this_thread::yield();
    granted_elsewhere = -1;
    manager.wait_until_idle();
    EXPECT_GE(refused_elsewhere, 2) << grant;
    const auto next = *Scene::prepare(*import_bytes(demo::write_glb(demo::terrain(300, 2)), {}));
    ASSERT_TRUE(manager.adopt(next));
    manager.wait_until_idle();
    EXPECT_TRUE(next->tree()->complete());
  }
}

TEST(StoreMemory, a_keeper_that_builds_nothing_ahead_remembers_no_scenes) {
  TreeCacheOptions options;
  options.ahead = false;
  TreeCacheManager manager(options);
  const auto adopt_many = [&] {
    for (int i = 0; i < 1000; ++i)
      ASSERT_TRUE(manager.adopt(text_scene("x"), std::string(64, 'a')));
    return;
  };
  adopt_many();
  const long before = living;
  adopt_many();
  EXPECT_LT(living - before, 100);
}

}  // namespace
}  // namespace sightline
