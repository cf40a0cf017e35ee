// Every allocation of an engine's answer fails once; in a program of its own, because it replaces
// the allocator.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "core/demo/demo.h"
#include "core/import/import.h"
#include "core/run/engine.h"

namespace {

/// How many more allocations are granted before one is refused; negative: all. Of the whole
/// program, as the allocator is.
std::atomic<long> granted{-1};

bool is_granted() {
  long left = granted.load();
  while (left >= 0) {
    if (granted.compare_exchange_weak(left, left - 1)) return left > 0;
  }
  return true;
}

void* allocate(std::size_t size, std::size_t alignment) {
  void* memory = nullptr;
  if (!is_granted() || ::posix_memalign(&memory, alignment, size == 0 ? 1 : size) != 0) {
    throw std::bad_alloc();
  }
  return memory;
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
// Not inline: a compiler that sees new end in free without seeing this new calls it a mismatch.
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace sightline {
namespace {

/// Calls ask() with its first allocation refused, then its second, ... until it makes no more.
template <class Ask>
void expect_every_failure_to_be_an_error(const Ask& ask) {
  int failures = 0;
  for (long grant = 0;; ++grant) {
    granted.store(grant);
    Status status = success();
    bool thrown = false;
    try {
      status = ask();
    } catch (const std::bad_alloc&) {
      thrown = true;
    }
    granted.store(-1);
    ASSERT_FALSE(thrown) << "after " << grant << " allocations";
    if (status) break;
    ++failures;
    ASSERT_EQ(status.error().code, "MEMORY_EXHAUSTED");
    ASSERT_EQ(status.error().kind, ErrorKind::kOutOfSpace);
    ASSERT_LT(grant, 100000);
  }
  EXPECT_GT(failures, 0);
}

class EngineMemory : public testing::Test {
 protected:
  void SetUp() override {
    auto description = import_bytes(demo::write_glb(demo::six_triangles()), {});
    ASSERT_TRUE(description.ok());
    scene_ = *Scene::build(std::move(*description));
    engine_ = *Engine::create({.threads = 1, .kernel = ""});
    for (int i = 0; i < 200; ++i) {
      rays_.push_back({{-10, 1, 0}, {1, 0, 0}});
      boxes_.push_back(Box3d{{-10, -10, -10}, {10, 10, 10}});
    }
  }

  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<Engine> engine_;
  RayBatch rays_;
  BoxBatch boxes_;
  Deadline never_ = Deadline::never();
};

TEST_F(EngineMemory, answers_with_an_error_whichever_allocation_of_rays_fails) {
  expect_every_failure_to_be_an_error([&] {
    HitBatch hits;
    return engine_->closest(*scene_, rays_, never_, hits);
  });
  expect_every_failure_to_be_an_error([&] {
    Column<std::uint8_t> occluded;
    return engine_->any(*scene_, rays_, never_, occluded);
  });
  expect_every_failure_to_be_an_error([&] {
    Column<std::uint64_t> totals;
    return engine_->count(*scene_, rays_, Crossings::kEvery, never_, totals);
  });
  expect_every_failure_to_be_an_error([&] {
    HitLists lists;
    Column<std::uint64_t> totals;
    return engine_->all(*scene_, rays_, {Crossings::kEvery, 9, 9999}, never_, lists, totals);
  });
  HitBatch hits;
  ASSERT_TRUE(engine_->closest(*scene_, rays_, never_, hits).ok());
  expect_every_failure_to_be_an_error([&] {
    Column<HitDetail> details;
    return engine_->details(*scene_, rays_, hits, never_, details);
  });
}

TEST_F(EngineMemory, answers_with_an_error_whichever_allocation_of_boxes_fails) {
  expect_every_failure_to_be_an_error([&] {
    RayBoxAnswers answers;
    return engine_->ray_boxes(rays_, boxes_, BoxPairing::kEach, RayBoxDetail::kPlanes, never_,
                              answers);
  });
  expect_every_failure_to_be_an_error([&] {
    Column<std::uint8_t> touched;
    return engine_->boxes_any(*scene_, boxes_, never_, touched);
  });
  for (const BoxTargets targets : {BoxTargets::kTriangles, BoxTargets::kNodes}) {
    expect_every_failure_to_be_an_error([&] {
      Column<std::uint64_t> totals;
      return engine_->boxes_count(*scene_, boxes_, targets, never_, totals);
    });
    expect_every_failure_to_be_an_error([&] {
      BoxLists lists;
      Column<std::uint64_t> totals;
      return engine_->boxes_list(*scene_, boxes_, targets, {9, 99999}, never_, lists, totals);
    });
  }
}

}  // namespace
}  // namespace sightline
