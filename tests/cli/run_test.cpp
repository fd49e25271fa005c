#include <gmock/gmock.h>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::IsEmpty;

class RunCommand : public FolderTest {
 protected:
  std::string scene(const std::string& jobs) {
    return write("scene.json",
                 R"({"version":1,"defaults":{"device":"cpu"},"jobs":[)" + jobs + "]}");
  }

  std::string torus_ = write("torus.obj", torus_obj(12));
  std::string plate_ = write("plate.obj", bumpy_plate_obj(6));
};

constexpr const char* kTwoJobs =
    R"({"name":"ring","input":"torus.obj","interpolation":"progressive","outputs":[{"path":"out/ring.glb","levels":[1,2]}],
        "report":"out/ring.json"},
       {"name":"sheet","input":"plate.obj","solve":{"preset":"paper"}})";

TEST_F(RunCommand, PrintsATableAndWritesBesideTheScene) {
  const ProcessResult result = run_planish({"run", scene(kTwoJobs)});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(
      result.out,
      AllOf(
          ContainsRegex(
              "name +points +vertices +solver +weights +iterations +error +fit ms +all ms\n"),
          ContainsRegex(
              "\nring +- +144 +chebyshev +doo-sabin +[0-9]+ +[-.0-9e]+ +[.0-9]+ +[.0-9]+\n"),
          ContainsRegex("\nsheet +- +49 +plain +averaged +[0-9]+ +[-.0-9e]+ +[.0-9]+ +[.0-9]+\n")));
  EXPECT_TRUE(exists("out/ring_LOD0.glb"));
  EXPECT_TRUE(exists("out/ring_LOD1.glb"));
  EXPECT_EQ(read_json("out/ring.json")["job"], "ring");
}

TEST_F(RunCommand, RunsTheJobsThatAreNamed) {
  const ProcessResult result = run_planish({"run", scene(kTwoJobs), "sheet"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, AllOf(HasSubstr("\nsheet "), testing::Not(HasSubstr("\nring "))));
  EXPECT_FALSE(exists("out"));
  EXPECT_EQ(run_planish({"run", scene(kTwoJobs), "shete"}).exit_code, 2);
}

TEST_F(RunCommand, AFailedJobDoesNotStopTheOthersAndExitsEight) {
  const ProcessResult result = run_planish(
      {"run", scene(R"({"name":"gone","input":"gone.obj"},{"name":"ring","input":"torus.obj"})")});
  EXPECT_EQ(result.exit_code, 8);
  EXPECT_THAT(result.out,
              AllOf(ContainsRegex("\ngone +- .*failed"), ContainsRegex("\nring +- +144 ")));
  EXPECT_THAT(result.err, AllOf(HasSubstr("gone: "), HasSubstr("1 of 2 jobs failed")));
}

TEST_F(RunCommand, AJobThatDoesNotConvergeCountsAsFailed) {
  const ProcessResult result = run_planish(
      {"run", scene(R"({"input":"plate.obj","max_iterations":1,"interpolation":"progressive"})")});
  EXPECT_EQ(result.exit_code, 8);
  EXPECT_THAT(result.out, HasSubstr("(not converged)"));
}

TEST_F(RunCommand, SceneErrorsExitTwo) {
  const ProcessResult result = run_planish({"run", scene(R"({"inptu":"torus.obj"})")});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("did you mean input?"));
  EXPECT_EQ(run_planish({"run", path("none.json")}).exit_code, 2);
}

TEST_F(RunCommand, OutputsAreCheckedBeforeAnyJobStarts) {
  const std::string file = scene(
      R"({"input":"torus.obj","outputs":[{"path":"a.glb"}]},
         {"input":"plate.obj","outputs":[{"path":"plate.obj"}]})");
  const ProcessResult result = run_planish({"run", file, "--force"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("jobs[1].outputs[0]"));
  EXPECT_FALSE(exists("a.glb"));
  EXPECT_EQ(read("plate.obj"), bumpy_plate_obj(6));
}

TEST_F(RunCommand, TwoJobsCannotWriteOneFile) {
  const std::string file = scene(
      R"({"input":"torus.obj","outputs":[{"path":"a.glb"}]},
         {"input":"plate.obj","outputs":[{"path":"./a.glb"}]})");
  EXPECT_EQ(run_planish({"run", file}).exit_code, 2);
}

TEST_F(RunCommand, ADryRunWritesNothing) {
  const ProcessResult result = run_planish({"run", scene(kTwoJobs), "--dry-run"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("ring_LOD1.glb"));
  EXPECT_THAT(result.err, IsEmpty());
  EXPECT_FALSE(exists("out"));
}

}  // namespace
}  // namespace planish::test
