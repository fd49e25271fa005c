#include <gmock/gmock.h>
#include <signal.h>

#include <chrono>
#include <thread>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/core/error.h"
#include "terminal.h"

namespace planish::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Interrupt : public FolderTest {
 protected:
  // Stops a fit that has seconds of work before it and is known to be at the step.
  ProcessResult stop_by(int signal, const std::string& step = "stencils") {
    const std::string input = write("torus.obj", torus_obj(150));
    PlanishProcess process({"fit", input, "-o", path("a.obj"), "--cage", path("c.obj"), "--report",
                            path("r.json"), "--levels", "4", "--progress", "json"},
                           {});
    EXPECT_TRUE(process.wait_for_message("\"" + step + "\""));
    const auto signalled = std::chrono::steady_clock::now();
    ::kill(process.id(), signal);
    ProcessResult result = process.finish();
    took_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - signalled).count();
    return result;
  }

  double took_ = 0;  ///< seconds from the signal to the end
};

TEST_F(Interrupt, SigintExits130AndLeavesNothingBehind) {
  const ProcessResult result = stop_by(SIGINT);
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_THAT(result.err, HasSubstr("interrupted; no partial file is left"));
  EXPECT_THAT(names(), ElementsAre("torus.obj"));
}

TEST_F(Interrupt, SigtermExits143AndLeavesNothingBehind) {
  EXPECT_EQ(stop_by(SIGTERM).exit_code, 143);
  EXPECT_THAT(names(), ElementsAre("torus.obj"));
}

TEST_F(Interrupt, EndsSoonWhereverTheWorkIs) {
  for (const char* step : {"read", "stencils", "solve", "measure", "write"}) {
    const ProcessResult result = stop_by(SIGINT, step);
    EXPECT_EQ(result.exit_code, 130) << step;
    // 0.2 s, and room for a machine that does other things as well.
    EXPECT_LT(took_, 1.0) << step;
    EXPECT_THAT(names(), ElementsAre("torus.obj")) << step;
  }
}

TEST_F(Interrupt, EndsARunOfSeveralJobs) {
  write("torus.obj", torus_obj(150));
  const std::string scene =
      write("scene.json",
            R"({"version":1,"defaults":{"device":"cpu"},"jobs":[)"
            R"({"name":"a","input":"torus.obj","outputs":[{"path":"a.obj","levels":[4]}]},)"
            R"({"name":"b","input":"torus.obj","outputs":[{"path":"b.obj","levels":[4]}]}]})");
  PlanishProcess process({"run", scene, "--progress", "json"}, {});
  EXPECT_TRUE(process.wait_for_message("\"stencils\""));
  ::kill(process.id(), SIGINT);
  const ProcessResult result = process.finish();
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_EQ(result.out, "");  // no table of jobs that failed
  EXPECT_THAT(result.err, HasSubstr("interrupted; no partial file is left"));
  EXPECT_THAT(names(), ElementsAre("scene.json", "torus.obj"));
}

TEST_F(Interrupt, TheSecondSignalKills) {
  const std::string input = write("torus.obj", torus_obj(150));
  int killed_by = 0;
  // The first may not yet be taken when the second comes, or the work may have ended.
  for (int attempt = 0; attempt < 60 && killed_by == 0; ++attempt) {
    PlanishProcess process(
        {"fit", input, "-o", path("a.obj"), "--levels", "4", "--progress", "json"}, {});
    EXPECT_TRUE(process.wait_for_message("\"stencils\""));
    ::kill(process.id(), SIGINT);
    std::this_thread::sleep_for(std::chrono::microseconds(20 * attempt));
    ::kill(process.id(), SIGINT);
    killed_by = process.finish().signal;
  }
  EXPECT_EQ(killed_by, SIGINT);
}

TEST(ExitCodes, FollowTheKindOfError) {
  using command::exit_code_of;
  using command::ExitCode;
  EXPECT_EQ(exit_code_of(ErrorCode::InvalidArgument), ExitCode::Usage);
  EXPECT_EQ(exit_code_of(ErrorCode::UnreadableInput), ExitCode::UnreadableInput);
  EXPECT_EQ(exit_code_of(ErrorCode::UnusableMesh), ExitCode::UnusableMesh);
  EXPECT_EQ(exit_code_of(ErrorCode::NoDevice), ExitCode::NoDevice);
  EXPECT_EQ(exit_code_of(ErrorCode::DeviceLost), ExitCode::NoDevice);
  EXPECT_EQ(exit_code_of(ErrorCode::OutOfMemory), ExitCode::NoDevice);
  EXPECT_EQ(exit_code_of(ErrorCode::UnwritableOutput), ExitCode::UnwritableOutput);
}

}  // namespace
}  // namespace planish::test
