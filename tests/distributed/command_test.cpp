// planish-mpi as people start it: exit codes, files, faults.
#include <gmock/gmock.h>

#include <fstream>

#include "cli/json_schema.h"
#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;

class MpiCommand : public FolderTest {
 protected:
  static ProcessResult on(int ranks, std::vector<std::string> arguments,
                          const std::string& fault = {}) {
    std::vector<std::string> all{"--oversubscribe", "-n", std::to_string(ranks)};
    if (!fault.empty()) all.insert(all.end(), {"-x", "PLANISH_MPI_FAULT"});
    all.emplace_back(PLANISH_MPI_PROGRAM);
    all.insert(all.end(), arguments.begin(), arguments.end());
    PlanishProcess::Options options;
    options.environment = {"OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1",
                           "HOME=/tmp"};
    if (!fault.empty()) options.environment.push_back("PLANISH_MPI_FAULT=" + fault);
    return run_planish(all, options);
  }

  std::string torus_ = write("torus.obj", torus_obj(16));
};

TEST_F(MpiCommand, WritesACageThatVerifyConfirmsAndAReport) {
  const ProcessResult result = on(3, {"fit", torus_, "--cage", path("c.ply"), "--report",
                                      path("r.json"), "--block-vertices", "50"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("256 vertices, 256 faces on 3 ranks"));
  const std::string verify = std::string(PLANISH_PROGRAM) + " verify " + path("c.ply") + " " +
                             torus_ + " > " + path("verify.txt") + " 2>&1";
  EXPECT_EQ(std::system(verify.c_str()), 0) << read("verify.txt");
  std::ifstream file(PLANISH_REPORT_SCHEMA);
  const json schema = json::parse(file);
  const json report = read_json("r.json");
  EXPECT_THAT(schema_problems(report, {{"$ref", "#/$defs/distributed"}}, schema), IsEmpty());
  EXPECT_THAT(schema_problems(report, schema), IsEmpty());
  EXPECT_EQ(report["ranks"].size(), 3u);
  EXPECT_EQ(report["halo"]["bytes_per_product"], 24 * report["halo"]["ghosts"].get<int>());
  EXPECT_EQ(report["exit_code"], 0);
}

TEST_F(MpiCommand, RefusesByNameWhatItHasNot) {
  const auto refusal = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"fit", torus_, "--cage", path("c.ply")});
    const ProcessResult result = on(2, arguments);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_FALSE(exists("c.ply"));
    return result.err;
  };
  EXPECT_THAT(refusal({"-o", "x/tileset.json"}), HasSubstr("-o,--output"));
  EXPECT_THAT(refusal({"--interpolation", "fair"}), HasSubstr("--interpolation: fair"));
  EXPECT_THAT(refusal({"--solver", "cg"}), HasSubstr("--solver: cg"));
  EXPECT_THAT(refusal({"--scheme", "loop"}), HasSubstr("--scheme: loop"));
  EXPECT_THAT(refusal({"--repair", "safe"}), HasSubstr("--repair: safe"));
  EXPECT_THAT(refusal({"--device", "vulkan"}), HasSubstr("--device"));
  EXPECT_THAT(refusal({"--precision", "float"}), HasSubstr("--precision: float"));
  EXPECT_THAT(refusal({"--creases", "auto"}), HasSubstr("--creases: auto"));
  EXPECT_THAT(refusal({"--nonsense"}), HasSubstr("--nonsense"));
}

TEST_F(MpiCommand, ExitCodesAreThoseOfPlanish) {
  const std::string cage = path("c.ply");
  const auto code = [&](const std::vector<std::string>& arguments) {
    return on(2, arguments).exit_code;
  };
  EXPECT_EQ(code({"--version"}), 0);
  EXPECT_EQ(code({"run", "scene.json"}), 2);
  EXPECT_EQ(code({"fit", torus_, "--cage", path("c.obj")}), 2);
  EXPECT_EQ(code({"fit", path("none.ply"), "--cage", cage}), 3);
  EXPECT_EQ(
      code({"fit", std::string(PLANISH_SCENES) + "/bad/non_manifold_vertex.obj", "--cage", cage}),
      4);
  EXPECT_EQ(code({"fit", torus_, "--cage", path("no/folder/c.ply")}), 7);
  EXPECT_EQ(names(), std::vector<std::string>{"torus.obj"});
  EXPECT_EQ(code({"fit", torus_, "--cage", cage, "--max-iterations", "1"}), 5);
  EXPECT_TRUE(exists("c.ply"));  // written, and flagged
  EXPECT_EQ(code({"fit", torus_, "--cage", cage}), 7);
  EXPECT_EQ(code({"fit", torus_, "--cage", cage, "-f", "--preset", "paper"}), 0);
}

// Whatever phase a rank dies in, the job ends, and the old output keeps its bytes.
class DyingRank : public MpiCommand, public testing::WithParamInterface<const char*> {};

TEST_P(DyingRank, LeavesTheOldOutputAsItWas) {
  const std::string cage = write("c.ply", "old");
  const std::vector<std::string> arguments{"fit", torus_, "--cage", cage, "-f", "--block-vertices",
                                           "50"};
  const ProcessResult killed = on(3, arguments, std::string("1:") + GetParam());
  EXPECT_NE(killed.exit_code, 0);
  EXPECT_EQ(read("c.ply"), "old");
  // A part that was left goes with the next run.
  ASSERT_EQ(on(2, arguments).exit_code, 0);
  EXPECT_EQ(names(), (std::vector<std::string>{"c.ply", "torus.obj"}));
  EXPECT_EQ(read("c.ply").substr(0, 4), "ply\n");
}

INSTANTIATE_TEST_SUITE_P(MpiCommand, DyingRank,
                         testing::Values("read", "sort", "faces", "rings", "rows", "solve",
                                         "write"),
                         [](const auto& phase) { return std::string(phase.param); });

TEST_F(MpiCommand, AHangingRankIsEndedByTheWatchdog) {
  const ProcessResult result =
      on(3, {"fit", torus_, "--cage", path("c.ply"), "--watchdog", "2", "--block-vertices", "50"},
         "1:faces:stop");
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("has come no further for 2 s"));
  EXPECT_FALSE(exists("c.ply"));
}

}  // namespace
}  // namespace planish::test
