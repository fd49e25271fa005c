#include "terminal.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace planish::command {
namespace {

// What `work` writes to stderr with a clock that it sets.
template <class Work>
std::string output_of(ProgressMode mode, const Work& work) {
  testing::internal::CaptureStderr();
  {
    double now = 100;
    Console console(LogLevel::Info, ColorMode::Never);
    Progress all(
        console, mode, [&now] { return now; }, 3);
    JobDisplay display(all, "goblet", 2);
    JobProgress progress(display.visit());
    progress.plan({{"read", 1}, {"solve", 2}, {"evaluate", 1}, {"evaluate", 4}});
    work(progress, now);
    all.finish();
  }
  return testing::internal::GetCapturedStderr();
}

TEST(Progress, PlainSpeaksAtMostEveryTenSeconds) {
  const std::string text = output_of(ProgressMode::Plain, [](JobProgress& progress, double& now) {
    for (int second = 0; second < 25; ++second) {
      now = 100 + second;
      progress.update("solve", second / 25.0);
    }
  });
  EXPECT_EQ(text, "goblet: 22%, solve, 34 s left\ngoblet: 32%, solve, 42 s left\n");
}

TEST(Progress, PlainIsSilentAboutShortWork) {
  EXPECT_EQ(output_of(ProgressMode::Plain,
                      [](JobProgress& progress, double&) { progress.update("solve", 1); }),
            "");
}

TEST(Progress, JsonHasOneLinePerStepAndPercent) {
  const std::string text =
      output_of(ProgressMode::JsonLines, [](JobProgress& progress, double& now) {
        progress.update("read", 0);
        progress.update("read", 0.001);
        now += 2;
        progress.update("solve", 0.5);
      });
  EXPECT_EQ(text,
            "{\"job\":\"goblet\",\"step\":\"read\",\"fraction\":0.0,\"number\":2,\"jobs\":3,"
            "\"share\":0.0,\"seconds\":0.0,\"seconds_left\":null}\n"
            "{\"job\":\"goblet\",\"step\":\"solve\",\"fraction\":0.5,\"number\":2,\"jobs\":3,"
            "\"share\":0.25,\"seconds\":2.0,\"seconds_left\":6.0}\n");
}

TEST(Progress, TheShareOfTheWholeNeverFalls) {
  std::vector<double> shares;
  (void)output_of(ProgressMode::None, [&](JobProgress& progress, double&) {
    for (const auto& [step, fraction] :
         std::vector<std::pair<const char*, double>>{{"read", 0},
                                                     {"solve", 0.5},
                                                     {"unknown", 1},
                                                     {"solve", 0.25},
                                                     {"evaluate", 0.5},
                                                     {"evaluate", 1},
                                                     {"evaluate", 0},
                                                     {"evaluate", 0.5},
                                                     {"evaluate", 1}}) {
      progress.update(step, fraction);
      shares.push_back(progress.share());
    }
  });
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_EQ(shares[5], 0.5);   // the first level of two, with a quarter of the second's weight
  EXPECT_EQ(shares[7], 0.75);  // half of the second
  EXPECT_EQ(shares.back(), 1);
}

TEST(Progress, WhatIsNotPlannedIsAPartOfTheStepUnderWay) {
  (void)output_of(ProgressMode::None, [&](JobProgress& progress, double&) {
    progress.update("read", 0);
    progress.update("solve", 0);
    progress.update("masks", 0.25);
    EXPECT_EQ(progress.share(), 1.5 / 8);
    progress.update("steps", 1);
    EXPECT_EQ(progress.share(), 3.0 / 8);
    progress.update("evaluate", 0);
    EXPECT_EQ(progress.share(), 3.0 / 8);
  });
}

TEST(Progress, TheBarIsDrawnInPlaceAndTakenAway) {
  const std::string text = output_of(ProgressMode::Bar, [](JobProgress& progress, double& now) {
    now += 1;
    progress.update("solve", 0.5);
  });
  EXPECT_EQ(text, "\r\033[K2/3 goblet  [######..................]  25%  solve, 3 s left\r\033[K");
}

TEST(Progress, AutoDrawsNoBarOutsideATerminal) {
  EXPECT_EQ(output_of(ProgressMode::Auto,
                      [](JobProgress& progress, double& now) {
                        now += 1;
                        progress.update("solve", 0.5);
                      }),
            "");
}

TEST(Progress, NoneSaysNothing) {
  EXPECT_EQ(output_of(ProgressMode::None,
                      [](JobProgress& progress, double& now) {
                        now += 100;
                        progress.update("solve", 0.5);
                      }),
            "");
}

}  // namespace
}  // namespace planish::command
