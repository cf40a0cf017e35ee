#include "core/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "core/base/thread_group.h"

namespace sightline {
namespace {

TEST(Parallel, a_loop_calls_every_piece_once) {
  for (const std::size_t count : {0u, 1u, 2u, 1000u}) {
    std::vector<int> calls(count, 0);
    parallel_for(count, [&](std::size_t i) { ++calls[i]; });
    EXPECT_EQ(calls, std::vector<int>(count, 1));
  }
}

TEST(Parallel, a_loop_hands_on_what_a_piece_throws) {
  const auto piece = [](std::size_t i) {
    if (i == 77) throw std::runtime_error("piece 77");
  };
  EXPECT_THROW(parallel_for(100, piece), std::runtime_error);
}

TEST(Parallel, both_branches_are_done_before_the_call_returns) {
  int first = 0, second = 0;
  parallel_invoke([&] { first = 1; }, [&] { second = 2; });
  EXPECT_EQ(first, 1);
  EXPECT_EQ(second, 2);
}

TEST(Parallel, branches_may_branch_again) {
  std::atomic<int> leaves{0};
  const auto grow = [&](const auto& self, int depth) -> void {
    if (depth == 0) {
      ++leaves;
      return;
    }
    parallel_invoke([&] { self(self, depth - 1); }, [&] { self(self, depth - 1); });
  };
  grow(grow, 5);
  EXPECT_EQ(leaves.load(), 32);
}

TEST(Parallel, a_reduction_joins_its_ranges_in_order) {
  // Joining lists is associative and not commutative: any other order would show.
  using List = std::vector<std::size_t>;
  const auto add = [](std::size_t begin, std::size_t end, List list) {
    for (std::size_t i = begin; i < end; ++i) list.push_back(i);
    return list;
  };
  const auto join = [](List a, const List& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  };
  List expected(990);
  std::iota(expected.begin(), expected.end(), std::size_t{10});
  EXPECT_EQ(parallel_reduce(10, 1000, 7, List{}, add, join), expected);
  EXPECT_EQ(parallel_reduce(10, 10, 7, List{}, add, join), List{});
}

TEST(Parallel, a_group_has_the_threads_it_was_started_with) {
  ThreadGroup group;
  group.start(3);
  EXPECT_EQ(group.threads(), 3);
  int done = 0;
  group.execute([&] { done = 1; });
  EXPECT_EQ(done, 1);
}

}  // namespace
}  // namespace sightline
