#include "planish/core/callbacks.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <thread>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"

namespace planish {
namespace {

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
