#include <gmock/gmock.h>
#include <signal.h>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/core/error.h"
#include "terminal/exit_codes.h"

namespace planish::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Interrupt : public FolderTest {
 protected:
  // Stops a fit that has seconds of work before it and is known to be at it.
  ProcessResult stop_by(int signal) {
    const std::string input = write("torus.obj", torus_obj(150));
    PlanishProcess process({"fit", input, "-o", path("a.obj"), "--cage", path("c.obj"), "--report",
                            path("r.json"), "--levels", "4", "--progress", "json"},
                           {});
    EXPECT_TRUE(process.wait_for_message("\"stencils\""));
    ::kill(process.id(), signal);
    return process.finish();
  }
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
