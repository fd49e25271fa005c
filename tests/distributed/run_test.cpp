// planish-mpi run: scene files over ranks.
#include <gmock/gmock.h>

#include <filesystem>
#include <sstream>

#include "cli/json_schema.h"
#include "distributed/mpi_command.h"
#include "support/files_below.h"

namespace planish::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;
using Files = std::vector<std::pair<std::string, std::string>>;

class MpiRun : public MpiCommand {
 protected:
  MpiRun() {
    for (const char* folder : {"a", "b", "c"}) std::filesystem::create_directory(path(folder));
  }
  [[nodiscard]] Files files(const std::string& folder) const { return files_below(path(folder)); }
  std::string scene(const std::string& folder, const json& defaults, const json& jobs) const {
    return write(folder + "/scene.json",
                 json{{"version", 1}, {"defaults", defaults}, {"jobs", jobs}}.dump(2));
  }
};

json tiles_and_cage() {
  return json::array({{{"path", "out/t.json"}}, {{"path", "out/c.ply"}, {"what", "cage"}}});
}

TEST_F(MpiRun, HasTheBytesOfFit) {
  const json jobs =
      json::array({{{"name", "smooth"},
                    {"input", "../torus.obj"},
                    {"levels", {1, 3}},
                    {"tile_vertices", 256},
                    {"skirts", true},
                    {"solve", {{"solver", "plain"}, {"tolerance", 1e-5}, {"weights", "averaged"}}},
                    {"outputs", tiles_and_cage()},
                    {"report", "out/r.json"}},
                   {{"name", "fair"},
                    {"input", "../torus.obj"},
                    {"up", "z"},
                    {"polish", 3},
                    {"interpolation", "fair"},
                    {"outputs", {{{"path", "f.json"}}}}}});
  const ProcessResult run = on(3, {"run", scene("a", {{"boundary", "edge-and-corner"}}, jobs)});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::filesystem::remove(path("a/scene.json"));
  std::filesystem::create_directory(path("b/out"));
  const ProcessResult smooth =
      on(2, {"fit", torus_, "--boundary", "edge-and-corner", "--levels", "1,3", "--tile-vertices",
             "256", "--skirts", "--solver", "plain", "--tolerance", "1e-5", "--weights", "averaged",
             "-o", path("b/out/t.json"), "--cage", path("b/out/c.ply")});
  ASSERT_EQ(smooth.exit_code, 0) << smooth.err;
  const ProcessResult fair =
      on(1, {"fit", torus_, "--boundary", "edge-and-corner", "--up", "z", "--polish", "3",
             "--interpolation", "fair", "-o", path("b/f.json")});
  ASSERT_EQ(fair.exit_code, 0) << fair.err;
  const json report = json::parse(read("a/out/r.json"));
  EXPECT_EQ(report["solve"]["solver"], "plain");
  EXPECT_EQ(report["outputs"].size(), 2u);
  std::filesystem::remove(path("a/out/r.json"));
  EXPECT_TRUE(files("a") == files("b"));
}

// The fair method has the bits of one machine, so the scene has those of planish run.
TEST_F(MpiRun, FairScenesHaveTheBytesOfPlanishRun) {
  const json defaults{{"repair", "none"}, {"device", "cpu"}, {"interpolation", "fair"}};
  const json jobs =
      json::array({{{"input", "../torus.obj"}, {"outputs", tiles_and_cage()}},
                   {{"name", "creased"},
                    {"input", "../torus.obj"},
                    {"crease_edges", {{0, 1}, {1, 2}, {2, 3}, {40, 41}, {41, 57}}},
                    {"corner_vertices", {100, 3}},
                    {"outputs", {{{"path", "x.json"}}, {{"path", "x.ply"}, {"what", "cage"}}}}},
                   {{"name", "tags off"},
                    {"input", "../torus.obj"},
                    {"crease_edges", {{0, 1}, {1, 2}}},
                    {"creases", "ignore"},
                    {"outputs", {{{"path", "y.ply"}, {"what", "cage"}}}}}});
  ASSERT_EQ(planish("run " + scene("a", defaults, jobs)), 0) << read("planish.txt");
  for (const int ranks : {1, 3}) {
    const ProcessResult run = on(ranks, {"run", scene("b", defaults, jobs), "-f"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_TRUE(files("a") == files("b")) << ranks;
  }
  EXPECT_NE(read("a/x.ply"), read("a/out/c.ply"));
}

TEST_F(MpiRun, ChosenJobsRunAndAFailedOneLeavesTheOthers) {
  write("cut.ply", "ply\nformat binary_little_endian 1.0\n");
  const json jobs = json::array(
      {{{"name", "cut"}, {"input", "../cut.ply"}, {"outputs", {{{"path", "cut.json"}}}}},
       {{"name", "whole"}, {"input", "../torus.obj"}, {"outputs", {{{"path", "whole.json"}}}}}});
  const std::string file = scene("a", json::object(), jobs);
  const ProcessResult both = on(2, {"run", file});
  EXPECT_EQ(both.exit_code, 8);
  EXPECT_THAT(both.err, HasSubstr("planish-mpi: error: job cut: "));
  EXPECT_THAT(both.err, HasSubstr("planish-mpi: error: 1 of 2 jobs failed"));
  EXPECT_TRUE(exists("a/whole.json"));
  EXPECT_FALSE(exists("a/cut.json"));
  EXPECT_EQ(on(2, {"run", file, "whole"}).exit_code, 7);  // is there
  EXPECT_EQ(on(2, {"run", file, "whole", "-f"}).exit_code, 0);
  const ProcessResult unknown = on(2, {"run", file, "hole"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("did you mean"));
}

TEST_F(MpiRun, WhatRanksHaveNotIsRefusedBeforeAnyWork) {
  const json jobs = json::array(
      {{{"name", "one"}, {"input", "../torus.obj"}, {"outputs", {{{"path", "t.json"}}}}},
       {{"name", "two"},
        {"input", "../torus.obj"},
        {"solve", {{"solver", "cg"}}},
        {"outputs", {{{"path", "u.json"}}}}}});
  const ProcessResult result = on(2, {"run", scene("a", json::object(), jobs)});
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_THAT(result.err, HasSubstr(path("a/scene.json:")));
  EXPECT_THAT(result.err, HasSubstr(": jobs[1].solve.solver: cg is not available in planish-mpi: "
                                    "take chebyshev or plain"));
  EXPECT_EQ(files("a").size(), 1u);  // the scene
}

TEST_F(MpiRun, DefaultsThatAJobOverrulesAreNotRefused) {
  const json defaults{{"solver", "cg"}, {"chord_errors", {0.01}}};
  const json jobs = json::array({{{"input", "../torus.obj"},
                                  {"solver", "plain"},
                                  {"levels", {1}},
                                  {"outputs", {{{"path", "t.json"}}}}}});
  const ProcessResult result = on(2, {"run", scene("a", defaults, jobs)});
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

TEST_F(MpiRun, TagsThatNameNoVertexAreRefused) {
  const json jobs = json::array({{{"input", "../torus.obj"},
                                  {"crease_edges", {{0, 256}}},
                                  {"outputs", {{{"path", "t.json"}}}}}});
  const ProcessResult result = on(2, {"run", scene("a", json::object(), jobs)});
  EXPECT_EQ(result.exit_code, 8);
  EXPECT_THAT(result.err, HasSubstr("crease_edges names vertex 256 of 256"));
  EXPECT_FALSE(exists("a/t.json"));
}

// A killed process leaves the file that it was writing, under a name of its own.
bool is_temporary(const std::string& name) {
  return name.starts_with("c.ply.") && name.ends_with(".tmp");
}

// One rank is killed in each phase of a fair scene.
class DyingRun : public MpiRun, public testing::WithParamInterface<const char*> {};

TEST_P(DyingRun, LeavesTheOldOutputAndIsResumedWithTheSameBytes) {
  const auto jobs = [](int polish) {
    return json::array({{{"input", "../torus.obj"},
                         {"interpolation", "fair"},
                         {"tile_vertices", 256},
                         {"polish", polish},
                         {"outputs", tiles_and_cage()}}});
  };
  const std::string undisturbed = scene("a", json::object(), jobs(8));
  ASSERT_EQ(on(1, {"run", undisturbed}).exit_code, 0);
  ASSERT_EQ(on(2, {"run", scene("b", json::object(), jobs(1))}).exit_code, 0);
  const Files old = files("b/out");
  const std::string file = scene("b", json::object(), jobs(8));
  const ProcessResult killed = on(3, {"run", file, "-f"}, std::string("1:") + GetParam());
  EXPECT_NE(killed.exit_code, 0);
  Files left = files("b/out");
  std::erase_if(left, [](const auto& one) {
    return one.first.starts_with(".t.json.part/") || is_temporary(one.first);
  });
  EXPECT_TRUE(left == old) << GetParam();
  const ProcessResult resumed = on(2, {"run", file, "-f", "--resume"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  Files now = files("b/out");
  std::erase_if(now, [&](const auto& one) { return is_temporary(one.first); });
  EXPECT_TRUE(now == files("a/out")) << GetParam();
}

INSTANTIATE_TEST_SUITE_P(MpiRun, DyingRun,
                         testing::Values("read", "sort", "faces", "rings", "rows", "solve", "tiles",
                                         "write"),
                         [](const auto& phase) { return std::string(phase.param); });

TEST_F(MpiRun, ProgressComesFromOneRankAsJsonLines) {
  const json jobs = json::array({{{"input", "../torus.obj"}, {"outputs", {{{"path", "t.json"}}}}}});
  const std::string file = scene("a", json::object(), jobs);
  const ProcessResult result = on(3, {"run", file, "--progress", "json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::vector<std::string> steps;
  double share = 0;
  std::istringstream lines(result.err);
  for (std::string line; std::getline(lines, line);) {
    const json said = json::parse(line);  // every line is JSON, the summary too
    if (!said.contains("step")) continue;
    if (steps.empty() || steps.back() != said["step"].get<std::string>())
      steps.push_back(said["step"]);
    EXPECT_GE(said["share"].get<double>(), share);
    share = said["share"];
  }
  EXPECT_EQ(steps, (std::vector<std::string>{"read", "sort", "faces", "rings", "rows", "solve",
                                             "tiles", "write"}));
  EXPECT_THAT(on(2, {"run", file, "-f", "-q"}).err, IsEmpty());
}

}  // namespace
}  // namespace planish::test
