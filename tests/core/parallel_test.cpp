#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "support/calls.h"

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

using std::chrono::milliseconds;

// More threads than a small machine has.
class HostScopes : public testing::Test {
  oneapi::tbb::global_control threads_{oneapi::tbb::global_control::max_allowed_parallelism, 4};
};

void sleep(milliseconds time) { std::this_thread::sleep_for(time); }

TEST_F(HostScopes, AskInEveryLoopOnTheCallingThreadAlone) {
  test::WatchingHost host;
  const Callbacks callbacks = host.callbacks();
  const HostScope scope(callbacks);
  LoopProgress progress(callbacks, "work", 0, 1, 200);
  parallel_for(200, 1, [&](std::size_t begin, std::size_t end) {
    sleep(milliseconds(2));
    progress.add(static_cast<std::int64_t>(end - begin));
  });
  EXPECT_GT(host.cancelled_calls(), 3);
  EXPECT_GT(host.progress_calls(), 2);  // the first before the loop
  host.expect_good("loop", false);
}

TEST(LoopProgress, TellsWhatIsDoneWheneverItsTimeHasCome) {
  std::vector<double> told;
  Callbacks callbacks;
  callbacks.progress = [&](std::string_view, double fraction) { told.push_back(fraction); };
  LoopProgress progress(callbacks, "work", 0.5, 1, 8);
  for (int i = 0; i < 3; ++i) {
    progress.add();
    sleep(milliseconds(21));
    check_stop();
    check_stop();  // too soon, and nothing new
  }
  EXPECT_EQ(told, (std::vector<double>{0.5, 0.5625, 0.625, 0.6875}));
}

TEST_F(HostScopes, TrueStopsTheWorkOnAllThreads) {
  Callbacks callbacks;
  std::atomic<bool> is_asked = false;
  callbacks.cancelled = [&] { return is_asked.exchange(true); };  // the second time
  std::atomic<int> pieces = 0;
  try {
    const HostScope scope(callbacks);
    parallel_for(100'000, 1, [&](std::size_t, std::size_t) {
      parallel_for(100'000, 1, [&](std::size_t, std::size_t) {
        sleep(milliseconds(1));
        ++pieces;
      });
    });
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Cancelled);
  }
  EXPECT_LT(pieces, 4000);
  EXPECT_NO_THROW(check_stop());  // the scope is gone
}

TEST_F(HostScopes, WhatACallbackThrowsComesOut) {
  Callbacks callbacks;
  callbacks.progress = [](std::string_view, double fraction) {
    if (fraction > 0) throw std::runtime_error("mine");
  };
  const HostScope scope(callbacks);
  LoopProgress progress(callbacks, "work", 0, 1, 100'000);
  EXPECT_THROW(parallel_for(100'000, 1,
                            [&](std::size_t, std::size_t) {
                              sleep(milliseconds(1));
                              progress.add();
                            }),
               std::runtime_error);
}

TEST(ShareOf, TellsAPartAndItsEndToTheBit) {
  std::vector<double> told;
  Callbacks callbacks;
  callbacks.progress = [&](std::string_view, double fraction) { told.push_back(fraction); };
  const Callbacks last = share_of(share_of(callbacks, 0.3, 1), 0.7, 1);
  last.report("a", 0);
  last.report("a", 0.5);
  last.report("a", 1);
  EXPECT_NEAR(told[0], 0.79, 1e-15);
  EXPECT_NEAR(told[1], 0.895, 1e-15);
  EXPECT_EQ(told[2], 1.0);
}

TEST(RoundParts, NeverFallAndNeverEnd) {
  std::vector<double> told;
  Callbacks callbacks;
  callbacks.progress = [&](std::string_view, double fraction) { told.push_back(fraction); };
  RoundParts rounds(callbacks, 0.5);
  for (int i = 0; i < 20; ++i) {
    const Callbacks round = rounds.next();
    round.report("a", 0);
    round.report("a", 1);
  }
  EXPECT_TRUE(std::ranges::is_sorted(told));
  EXPECT_EQ(told[1], 0.5);
  EXPECT_EQ(told[3], 0.75);
  EXPECT_LT(told.back(), 1);
}

using Clock = std::chrono::steady_clock;

ErrorCode code_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.code();
  }
  return ErrorCode::InvalidArgument;  // nothing was thrown
}

TEST(Stop, CountsOnlyWhileAScopeLives) {
  StopFlag flag = true;
  EXPECT_FALSE(stop_requested());
  {
    const StopScope scope(flag);
    EXPECT_TRUE(stop_requested());
    EXPECT_EQ(code_of([] { check_stop(); }), ErrorCode::Cancelled);
  }
  EXPECT_NO_THROW(check_stop());
}

TEST(Stop, NestedScopesEachCount) {
  StopFlag outer = false, inner = false;
  const StopScope first(outer);
  {
    const StopScope second(inner);
    EXPECT_FALSE(stop_requested());
    outer = true;
    EXPECT_TRUE(stop_requested());
    outer = false;
    inner = true;
    EXPECT_TRUE(stop_requested());
  }
  EXPECT_FALSE(stop_requested());
}

// Loops of seconds that stop when the flag is set from outside.
void expect_quick_end(const std::function<void()>& work) {
  StopFlag flag = false;
  std::atomic<Clock::rep> set_at = 0;
  std::jthread setter([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    set_at = Clock::now().time_since_epoch().count();
    flag = true;
  });
  const StopScope scope(flag);
  EXPECT_EQ(code_of(work), ErrorCode::Cancelled);
  const Clock::duration passed = Clock::now().time_since_epoch() - Clock::duration(set_at.load());
  // 10 ms of work; the rest is room for a machine that does other things as well.
  EXPECT_LT(std::chrono::duration_cast<std::chrono::milliseconds>(passed).count(), 500);
}

void spin(std::chrono::microseconds time) {
  const auto end = Clock::now() + time;
  while (Clock::now() < end) {
  }
}

TEST(Stop, EndsAParallelLoopOnAllThreads) {
  expect_quick_end([] {
    parallel_for(20'000'000, 1000,
                 [](std::size_t, std::size_t) { spin(std::chrono::microseconds(1000)); });
  });
}

// The calling thread stays in its piece until long after the flag is set: only what the other
// threads look at can keep them from beginning more pieces.
TEST(Stop, OtherThreadsLookThemselves) {
  if (oneapi::tbb::this_task_arena::max_concurrency() < 2) GTEST_SKIP() << "one thread";
  const oneapi::tbb::global_control threads(oneapi::tbb::global_control::max_allowed_parallelism,
                                            4);
  const std::thread::id own = std::this_thread::get_id();
  StopFlag flag = false;
  std::atomic<int> by_others = 0, after_the_flag = 0;
  const StopScope scope(flag);
  const auto wait_until = [](Clock::duration longest, const auto& is_so) {
    const auto end = Clock::now() + longest;
    while (!is_so() && Clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  EXPECT_EQ(code_of([&] {
              parallel_for(100'000, 1, [&](std::size_t, std::size_t) {
                if (std::this_thread::get_id() == own) {
                  wait_until(std::chrono::seconds(5), [&] { return by_others > 3; });
                  flag = true;
                  std::this_thread::sleep_for(std::chrono::milliseconds(100));
                  return;
                }
                if (flag) ++after_the_flag;
                ++by_others;
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
              });
            }),
            ErrorCode::Cancelled);
  EXPECT_GT(by_others, 3);
  EXPECT_LE(after_the_flag, 3);  // each had looked when it was set
}

TEST(Stop, EndsNestedLoops) {
  expect_quick_end([] {
    parallel_for(100'000, 1, [](std::size_t, std::size_t) {
      parallel_for(100'000, 10,
                   [](std::size_t, std::size_t) { spin(std::chrono::microseconds(100)); });
    });
  });
}

TEST(Stop, EndsASerialLoop) {
  expect_quick_end([] {
    StopCheck stop;
    for (std::uint64_t i = 0; i < 1'000'000'000'000; ++i) {
      stop.step();
      std::atomic_signal_fence(std::memory_order_seq_cst);
    }
  });
}

TEST(Stop, LeavesNoFile) {
  const auto path = std::filesystem::temp_directory_path() / "planish_stop_test";
  std::filesystem::create_directories(path);
  StopFlag flag = false;
  {
    const StopScope scope(flag);
    EXPECT_EQ(code_of([&] {
                OutputFile file(path / "a");
                file.write("some");
                flag = true;
                file.write("more");
                file.commit();
              }),
              ErrorCode::Cancelled);
  }
  EXPECT_TRUE(std::filesystem::is_empty(path));
  std::filesystem::remove_all(path);
}

TEST(Stop, PiecesOfALoopAreTheSameWithAScope) {
  const StopFlag flag = false;
  const StopScope scope(flag);
  std::vector<std::atomic<int>> visits(100'003);
  parallel_for(visits.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) ++visits[i];
  });
  for (const auto& visit : visits) ASSERT_EQ(visit, 1);
}

}  // namespace
}  // namespace planish
