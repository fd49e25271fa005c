#include "planish/core/parallel.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace planish {
namespace {

TEST(ParallelFor, VisitsEachIndexOnce) {
  for (const std::size_t count : {0u, 1u, 63u, 64u, 65u, 10000u}) {
    std::vector<std::atomic<int>> visits(count);
    parallel_for(count, 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
    for (const auto& visit : visits) ASSERT_EQ(visit, 1);
  }
}

TEST(ParallelEach, VisitsEachIndexOnce) {
  for (const std::size_t count : {0u, 1u, 65u, 10000u}) {
    std::vector<std::atomic<int>> visits(count);
    parallel_each(count, 64, [&](std::size_t i) { ++visits[i]; });
    parallel_each(count, [&](std::size_t i) { ++visits[i]; });
    for (const auto& visit : visits) ASSERT_EQ(visit, 2);
  }
}

TEST(OrderedReduce, JoinsPiecesOfFixedLengthInTheirOrder) {
  using Ranges = std::vector<std::size_t>;
  const auto of_range = [](std::size_t begin, std::size_t end) { return Ranges{begin, end}; };
  const auto join = [](Ranges& all, const Ranges& one) {
    all.insert(all.end(), one.begin(), one.end());
  };
  EXPECT_EQ(ordered_reduce(0, 4, Ranges{7}, of_range, join), (Ranges{7}));
  EXPECT_EQ(ordered_reduce(8, 4, Ranges{}, of_range, join), (Ranges{0, 4, 4, 8}));
  EXPECT_EQ(ordered_reduce(10, 4, Ranges{7}, of_range, join), (Ranges{7, 0, 4, 4, 8, 8, 10}));
}

TEST(OrderedReduce, SumsToTheSameBitsForEveryThreadCount) {
  const auto sum = [] {
    return ordered_reduce(
        1'000'003, 1000, 0.0,
        [](std::size_t begin, std::size_t end) {
          double piece = 0;
          for (std::size_t i = begin; i < end; ++i) piece += 1.0 / (1.0 + static_cast<double>(i));
          return piece;
        },
        [](double& total, double piece) { total += piece; });
  };
  const double with_all = sum();
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(sum(), with_all);
}

TEST(ParallelFor, PassesExceptionsOn) {
  EXPECT_THROW(parallel_for(10000, 16,
                            [](std::size_t begin, std::size_t) {
                              if (begin > 0) throw std::runtime_error("piece failed");
                            }),
               std::runtime_error);
}

// One piece of the outer loop fails while another is within its inner loop, whose pieces wait for
// that.
TEST(ParallelFor, EndsWholeWithinALoopThatFails) {
  if (oneapi::tbb::this_task_arena::max_concurrency() < 2) GTEST_SKIP() << "one thread";
  constexpr std::size_t kCount = 64;
  std::atomic<bool> is_within = false;
  std::atomic<std::size_t> done = 0;
  const auto wait = [](const auto& until) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(200);
    while (!until() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  };
  std::atomic<bool> has_failed = false;
  EXPECT_THROW(parallel_each(2, 1,
                             [&](std::size_t outer) {
                               if (outer == 1) {
                                 wait([&] { return is_within.load(); });
                                 has_failed = true;
                                 throw std::runtime_error("piece failed");
                               }
                               parallel_each(kCount, 1, [&](std::size_t) {
                                 is_within = true;
                                 wait([&] { return has_failed.load(); });
                                 // Until TBB has heard of it.
                                 std::this_thread::sleep_for(std::chrono::milliseconds(1));
                                 ++done;
                               });
                               EXPECT_EQ(done, kCount);
                             }),
               std::runtime_error);
}

}  // namespace
}  // namespace planish
