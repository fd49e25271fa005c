#include "planish/core/callbacks.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "support/watching_host.h"

namespace planish {
namespace {

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

}  // namespace
}  // namespace planish
