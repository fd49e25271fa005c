#include "terminal/progress.h"

#include <gmock/gmock.h>

namespace planish::command {
namespace {

// What `work` writes to stderr with a clock that it sets.
template <class Work>
std::string output_of(ProgressMode mode, const Work& work) {
  testing::internal::CaptureStderr();
  {
    double now = 100;
    Console console(LogLevel::Info, ColorMode::Never);
    Progress progress(console, mode, [&now] { return now; });
    progress.begin_job("goblet");
    work(progress, now);
    progress.finish();
  }
  return testing::internal::GetCapturedStderr();
}

TEST(Progress, PlainSpeaksAtMostEveryTenSeconds) {
  const std::string text = output_of(ProgressMode::Plain, [](Progress& progress, double& now) {
    for (int second = 0; second < 25; ++second) {
      now = 100 + second;
      progress.update("solve", second / 25.0);
    }
  });
  EXPECT_EQ(text, "goblet: solve 40%\ngoblet: solve 80%\n");
}

TEST(Progress, PlainIsSilentAboutShortWork) {
  EXPECT_EQ(output_of(ProgressMode::Plain,
                      [](Progress& progress, double&) { progress.update("solve", 1); }),
            "");
}

TEST(Progress, JsonHasOneLinePerStepAndPercent) {
  const std::string text = output_of(ProgressMode::Json, [](Progress& progress, double&) {
    progress.update("read", 0);
    progress.update("read", 0.001);
    progress.update("solve", 0.5);
  });
  EXPECT_EQ(text,
            "{\"job\":\"goblet\",\"step\":\"read\",\"fraction\":0.0}\n"
            "{\"job\":\"goblet\",\"step\":\"solve\",\"fraction\":0.5}\n");
}

TEST(Progress, TheBarIsDrawnInPlaceAndTakenAway) {
  const std::string text = output_of(ProgressMode::Bar, [](Progress& progress, double& now) {
    now += 1;
    progress.update("solve", 0.5);
  });
  EXPECT_EQ(text, "\r\033[Kgoblet  [############............]  50%  solve\r\033[K");
}

TEST(Progress, AutoDrawsNoBarOutsideATerminal) {
  EXPECT_EQ(output_of(ProgressMode::Auto,
                      [](Progress& progress, double& now) {
                        now += 1;
                        progress.update("solve", 0.5);
                      }),
            "");
}

TEST(Progress, NoneSaysNothing) {
  EXPECT_EQ(output_of(ProgressMode::None,
                      [](Progress& progress, double& now) {
                        now += 100;
                        progress.update("solve", 0.5);
                      }),
            "");
}

}  // namespace
}  // namespace planish::command
