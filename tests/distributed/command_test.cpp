#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "cli/json_schema.h"
#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "support/files.h"

namespace planish::test {
namespace {

// A folder with a torus of 256 vertices, and planish-mpi as people start it.
class MpiCommand : public FolderTest {
 protected:
  // `fault`: "rank:phase"; `before`: flags and programs between mpirun and planish-mpi.
  [[nodiscard]] static ProcessResult on(int ranks, std::vector<std::string> arguments,
                                        const std::string& fault = {},
                                        const std::vector<std::string>& before = {});
  // planish on one machine; its exit code.
  [[nodiscard]] int planish(const std::string& arguments) const;

  std::string torus_ = write("torus.obj", torus_obj(16));
};

ProcessResult MpiCommand::on(int ranks, std::vector<std::string> arguments,
                             const std::string& fault, const std::vector<std::string>& before) {
  std::vector<std::string> all{"--oversubscribe", "-n", std::to_string(ranks)};
  if (!fault.empty()) all.insert(all.end(), {"-x", "PLANISH_MPI_FAULT"});
  all.insert(all.end(), before.begin(), before.end());
  all.emplace_back(PLANISH_MPI_PROGRAM);
  all.insert(all.end(), arguments.begin(), arguments.end());
  PlanishProcess::Options options;
  // All ranks are here: no other network is looked at, which may be none, or none that is allowed.
  options.environment = {"OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1",
                         "OMPI_MCA_btl_tcp_if_include=lo", "HOME=/tmp"};
  if (!fault.empty()) options.environment.push_back("PLANISH_MPI_FAULT=" + fault);
  return run_planish(all, options);
}

int MpiCommand::planish(const std::string& arguments) const {
  const std::string line =
      std::string(PLANISH_PROGRAM) + " " + arguments + " > " + path("planish.txt") + " 2>&1";
  const int status = std::system(line.c_str());
  return WEXITSTATUS(status);
}

// planish-mpi as people start it: exit codes, files, faults.

using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;

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

TEST_F(MpiCommand, FairTilesHaveTheBytesOfPlanish) {
  const std::string one = std::string(PLANISH_PROGRAM) + " fit " + torus_ +
                          " --interpolation fair --up z --repair none --precision double -o " +
                          path("t.json") + " > " + path("one.txt") + " 2>&1";
  ASSERT_EQ(std::system(one.c_str()), 0) << read("one.txt");
  const auto expected = files_below(path("t"));
  const std::string document = read("t.json");
  for (const char* polish : {"8", "2"}) {
    const ProcessResult result =
        on(3, {"fit", torus_, "--interpolation", "fair", "--up", "z", "-o", path("t.json"), "-f",
               "--report", path("r.json"), "--polish", polish});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, HasSubstr("fair, largest vertex error"));
    EXPECT_THAT(result.err, HasSubstr("level 1: 1 tile, "));
    const bool is_same = files_below(path("t")) == expected && read("t.json") == document;
    EXPECT_EQ(is_same, polish == std::string("8"));
    std::ifstream file(PLANISH_REPORT_SCHEMA);
    const json report = read_json("r.json");
    EXPECT_THAT(schema_problems(report, json::parse(file)), IsEmpty());
    EXPECT_EQ(report["solve"]["fair"]["polish"], std::stoi(polish));
  }
}

// Its vertices carry noise: then the surface bends least with the whole bound, which ranks take
// without measuring.
std::string roughened(const std::string& obj) {
  std::istringstream lines(obj);
  std::ostringstream result;
  result.precision(17);
  std::string line;
  for (int vertex = 0; std::getline(lines, line);) {
    if (!line.starts_with("v ")) {
      result << line << '\n';
      continue;
    }
    std::istringstream numbers(line.substr(2));
    double x = 0, y = 0, z = 0;
    numbers >> x >> y >> z;
    const double size = 1 + 0.04 * (vertex++ * 7919 % 97 / 97.0 - 0.5);
    result << "v " << size * x << ' ' << size * y << ' ' << size * z << '\n';
  }
  return result.str();
}

// Vertices are left by what one machine leaves them by, to the bit.
TEST_F(MpiCommand, LeavesVerticesAsPlanishDoes) {
  torus_ = write("rough.obj", roughened(read("torus.obj")));
  for (const std::string method : {"fair", "progressive"}) {
    const std::vector<std::string> arguments{
        "fit",      torus_,         "--within", "0.004",       "--interpolation", method,
        "-o",       path("t.json"), "--cage",   path("c.ply"), "--tile-vertices", "256",
        "--report", path("r.json"), "-f"};
    std::string one = PLANISH_PROGRAM;
    for (const std::string& argument : arguments) one += " " + argument;
    one += " --repair none --precision double > " + path("one.txt") + " 2>&1";
    ASSERT_EQ(std::system(one.c_str()), 0) << read("one.txt");
    const auto tiles = files_below(path("t"));
    const json expected = read_json("r.json")["solve"]["within"];
    EXPECT_GT(expected["at_bound"], 0);
    std::string cage;
    for (const int ranks : {1, 3, 5}) {
      const ProcessResult result = on(ranks, arguments);
      ASSERT_EQ(result.exit_code, 0) << result.err;
      EXPECT_THAT(result.err, HasSubstr("within 0.004 of the diagonal: vertices are left by"));
      const json within = read_json("r.json")["solve"]["within"];
      for (const char* key : {"allowed", "noise", "at_bound"})
        EXPECT_EQ(within[key], expected[key]);
      EXPECT_EQ(within["distance"]["max"], expected["distance"]["max"]);
      for (const char* key : {"bending_before", "bending_after"})
        EXPECT_NEAR(within[key].get<double>(), expected[key].get<double>(),
                    1e-12 * expected[key].get<double>());
      if (method == "fair") {
        EXPECT_TRUE(files_below(path("t")) == tiles) << ranks;
      }
      if (ranks == 1) cage = read("c.ply");
      EXPECT_TRUE(read("c.ply") == cage) << method << ranks;
      const std::string verify = std::string(PLANISH_PROGRAM) + " verify " + path("c.ply") + " " +
                                 torus_ + " > " + path("verify.txt") + " 2>&1";
      EXPECT_EQ(std::system(verify.c_str()), 0) << read("verify.txt");
    }
  }
  const ProcessResult measured =
      on(2, {"fit", torus_, "--within", "auto", "--cage", path("x.ply")});
  EXPECT_EQ(measured.exit_code, 2) << measured.err;
  EXPECT_THAT(measured.err, HasSubstr("ranks do not measure noise; say how far, such as 0.001"));
}

// With colours, texture coordinates that have a seam, and materials that begin within the file.
std::string with_attributes(const std::string& obj) {
  std::istringstream lines(obj);
  std::string text;
  int vertices = 0, faces = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("v ")) {
      text += line + " 0." + std::to_string(++vertices % 10) + " 0.5 1\n";
      text += "vt 0." + std::to_string(vertices) + " " + std::to_string(vertices % 16) + "\n";
    } else if (line.starts_with("f ")) {
      if (++faces % 60 == 30) text += "usemtl m" + std::to_string(faces % 7) + "\n";
      if (faces % 50 == 20) text += "g part " + std::to_string(faces) + "\n";
      std::istringstream corners(line.substr(2));
      text += "f";
      for (int v = 0; corners >> v;)
        text += " " + std::to_string(v) + "/" + std::to_string(faces > 100 ? v : 257 - v);
      text += "\n";
    } else {
      text += line + "\n";
    }
  }
  return text;
}

TEST_F(MpiCommand, TilesWithAttributesHaveTheBytesOfPlanish) {
  const std::string input = write("laden.obj", with_attributes(read("torus.obj")));
  const std::vector<std::string> flags{"fit",     input,          "--interpolation", "fair",
                                       "-o",      path("t.json"), "--tile-vertices", "256",
                                       "--skirts"};
  std::string one = PLANISH_PROGRAM;
  for (const std::string& flag : flags) one += " " + flag;
  one += " --repair none --precision double > " + path("one.txt") + " 2>&1";
  ASSERT_EQ(std::system(one.c_str()), 0) << read("one.txt");
  const auto expected = files_below(path("t"));
  const std::string document = read("t.json");
  ASSERT_GT(expected.size(), 4u);
  for (const char* name : {"TEXCOORD_0", "COLOR_0", "m0", "m6"})
    EXPECT_TRUE(std::ranges::any_of(expected, [&](const auto& file) {
      return file.second.find(name) != std::string::npos;
    })) << name;
  for (const int ranks : {1, 2, 3, 5, 8}) {
    std::vector<std::string> again = flags;
    again.push_back("-f");
    const ProcessResult result = on(ranks, again);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, testing::Not(HasSubstr("warning")));
    EXPECT_TRUE(files_below(path("t")) == expected) << ranks;
    EXPECT_TRUE(read("t.json") == document) << ranks;
  }
}

TEST_F(MpiCommand, TellsOfAFairCageThatCarriesNothing) {
  const std::string input = write("laden.obj", with_attributes(read("torus.obj")));
  for (const char* method : {"fair", "progressive"}) {
    const ProcessResult result =
        on(2, {"fit", input, "--interpolation", method, "--cage", path("c.ply"), "-f"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err.find("without the mesh's colours") != std::string::npos,
              method == std::string("fair"))
        << result.err;
  }
}

TEST_F(MpiCommand, SaysWhyItTookAMethod) {
  const ProcessResult by_itself = on(2, {"fit", torus_, "--report", path("r.json")});
  EXPECT_THAT(by_itself.err, HasSubstr("method progressive: ranks do not measure both"));
  EXPECT_THAT(read_json("r.json")["solve"]["choice"]["reason"].get<std::string>(),
              HasSubstr("ranks do not measure"));
  const ProcessResult named =
      on(2, {"fit", torus_, "--report", path("r.json"), "-f", "--interpolation", "progressive"});
  EXPECT_THAT(named.err, testing::Not(HasSubstr("method")));
  EXPECT_TRUE(read_json("r.json")["solve"]["choice"].is_null());
}

TEST_F(MpiCommand, RefusesByNameWhatItHasNot) {
  const auto refusal = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"fit", torus_, "--cage", path("c.ply")});
    const ProcessResult result = on(2, arguments);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_FALSE(exists("c.ply"));
    return result.err;
  };
  EXPECT_THAT(refusal({"-o", path("x.glb")}), HasSubstr("-o: "));
  EXPECT_THAT(refusal({"-o", path("x.json"), "--levels", "0"}), HasSubstr("--levels: "));
  EXPECT_THAT(
      refusal({"--weld", "0.1"}),
      HasSubstr("planish-mpi: error: --weld: 0.1 is not available in planish-mpi: nothing is "
                "welded over ranks; planish fit IN --weld"));
  EXPECT_THAT(refusal({"--nonsense"}), HasSubstr("--nonsense"));
}

// What the refusal of --weld and --repair advises.
TEST_F(MpiCommand, WhatPlanishHasWeldedIsTaken) {
  // Two squares beside each other, of eight vertices.
  const std::string apart = write("apart.obj",
                                  "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 0\nv 2 0 0\n"
                                  "v 2 1 0\nv 1 1 1e-9\nf 1 2 3 4\nf 5 6 7 8\n");
  const std::string welded = path("welded.obj");
  // Flat, with its corners kept: no iteration is needed.
  EXPECT_EQ(planish("fit " + apart + " --weld 1e-6 --max-iterations 0 --cage " + welded), 0)
      << read("planish.txt");
  ASSERT_EQ(on(2, {"fit", welded, "--cage", path("c.ply")}).exit_code, 0);
  EXPECT_THAT(read("c.ply"), HasSubstr("element vertex 6\n"));
  EXPECT_THAT(read("welded.obj"), HasSubstr("v 2 1 0\n"));
}

TEST_F(MpiCommand, ExitCodesAreThoseOfPlanish) {
  const std::string cage = path("c.ply");
  const auto code = [&](const std::vector<std::string>& arguments) {
    return on(2, arguments).exit_code;
  };
  EXPECT_EQ(code({"--version"}), 0);
  EXPECT_EQ(code({"run", path("scene.json")}), 2);
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
  const std::string document = write("t.json", "old");
  write("t/0/0-1-0.glb", "old");
  const std::vector<std::string> arguments{"fit", torus_,   "--cage",          cage, "-f",
                                           "-o",  document, "--tile-vertices", "256"};
  const ProcessResult killed = on(3, arguments, std::string("1:") + GetParam());
  EXPECT_NE(killed.exit_code, 0);
  EXPECT_EQ(read("c.ply"), "old");
  EXPECT_EQ(read("t.json"), "old");
  EXPECT_EQ(read("t/0/0-1-0.glb"), "old");
  // Tiles that were left go with the next run; a temporary of a name of its own stays.
  ASSERT_EQ(on(2, arguments).exit_code, 0);
  std::vector<std::string> left = names();
  std::erase_if(left, [](const std::string& name) {
    return name.starts_with("c.ply.") && name.ends_with(".tmp");
  });
  EXPECT_EQ(left, (std::vector<std::string>{"c.ply", "t", "t.json", "torus.obj"}));
  EXPECT_NE(read("t/0/0-1-0.glb"), "old");
  EXPECT_EQ(read("c.ply").substr(0, 4), "ply\n");
}

INSTANTIATE_TEST_SUITE_P(MpiCommand, DyingRank,
                         testing::Values("read", "sort", "faces", "rings", "rows", "solve", "tiles",
                                         "write"),
                         [](const auto& phase) { return std::string(phase.param); });

class MpiTiles : public MpiCommand {
 protected:
  ProcessResult tiles_on(int ranks, std::vector<std::string> more = {},
                         const std::string& fault = {},
                         const std::vector<std::string>& before = {}) {
    std::vector<std::string> arguments{"fit", torus_, "-o", path("t.json"), "--tile-vertices",
                                       "256", "-f"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return on(ranks, arguments, fault, before);
  }
  [[nodiscard]] json read_report() const {
    const json report = read_json("r.json");
    std::ifstream file(PLANISH_REPORT_SCHEMA);
    const json schema = json::parse(file);
    EXPECT_THAT(schema_problems(report, {{"$ref", "#/$defs/distributed"}}, schema), IsEmpty());
    return report;
  }
};

TEST_F(MpiTiles, AreAsPlanishHasThemButForTheSolve) {
  ASSERT_EQ(tiles_on(3, {"--report", path("r.json"), "--skirts", "--tolerance", "1e-10"}).exit_code,
            0);
  const std::string planish =
      std::string(PLANISH_PROGRAM) + " fit " + torus_ + " -o " + path("one.json") +
      " --tile-vertices 256 --skirts --precision double --interpolation progressive --device cpu" +
      " --tolerance 1e-10 --report " + path("one_r.json") + " > " + path("log.txt") + " 2>&1";
  ASSERT_EQ(std::system(planish.c_str()), 0) << read("log.txt");
  // Both solves stop near the limit, and the grid of positions is coarser than what is between.
  const auto tiles = files_below(path("t")), expected = files_below(path("one"));
  ASSERT_EQ(tiles.size(), expected.size());
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    EXPECT_EQ(tiles[i].first, expected[i].first);
    EXPECT_EQ(tiles[i].second.size(), expected[i].second.size()) << tiles[i].first;
  }
  const json report = read_report(), one = read_json("one_r.json");
  EXPECT_EQ(report["outputs"][0]["vertices"], one["outputs"][0]["vertices"]);
  EXPECT_EQ(report["outputs"][0]["quads"], one["outputs"][0]["quads"]);
  EXPECT_EQ(report["outputs"][0]["tiles"][0]["tiles"], one["outputs"][0]["tiles"][0]["tiles"]);
  for (const char* figure : {"folded_area", "rms_normal_deviation", "bending"})
    EXPECT_NEAR(report["surface"][figure].get<double>(), one["surface"][figure].get<double>(),
                1e-7 * (1 + one["surface"][figure].get<double>()))
        << figure;
  EXPECT_EQ(report["outputs"][0]["resumed_blocks"], 0);
}

TEST_F(MpiTiles, AnEndedJobLeavesTheOldSetAndIsResumed) {
  ASSERT_EQ(tiles_on(1, {"--levels", "3"}).exit_code, 0);
  const auto undisturbed = files_below(path("t"));
  const std::string document = read("t.json");
  ASSERT_EQ(tiles_on(2, {"--levels", "1"}).exit_code, 0);
  const auto old = files_below(path("t"));
  const std::string old_document = read("t.json");
  // Another rank has written some blocks when this one dies.
  const ProcessResult killed = tiles_on(2, {"--levels", "3"}, "1:tiles");
  EXPECT_NE(killed.exit_code, 0);
  EXPECT_EQ(files_below(path("t")), old);
  EXPECT_EQ(read("t.json"), old_document);
  EXPECT_TRUE(exists(".t.json.part"));
  // With other options nothing of it is taken; that run dies too, and leaves its own.
  EXPECT_NE(tiles_on(3, {"--levels", "4", "--resume"}, "2:write").exit_code, 0);
  EXPECT_EQ(read("t.json"), old_document);
  EXPECT_NE(tiles_on(3, {"--levels", "3", "--resume"}, "1:write").exit_code, 0);
  ASSERT_EQ(tiles_on(2, {"--levels", "3", "--resume", "--report", path("r.json")}).exit_code, 0);
  EXPECT_EQ(files_below(path("t")), undisturbed);
  EXPECT_EQ(read("t.json"), document);
  const json output = read_report()["outputs"][0];
  EXPECT_EQ(output["resumed_blocks"], output["blocks"]);
  EXPECT_EQ(names(), (std::vector<std::string>{"r.json", "t", "t.json", "torus.obj"}));
}

// In each phase, with all that may ride on a mesh.
TEST_F(MpiTiles, WithAttributesAreResumedAfterAnyPhase) {
  torus_ = write("laden.obj", with_attributes(read("torus.obj")));
  ASSERT_EQ(tiles_on(1, {"--levels", "2"}).exit_code, 0);
  const auto undisturbed = files_below(path("t"));
  const std::string document = read("t.json");
  std::int64_t resumed = 0;
  for (const char* phase : {"read", "sort", "faces", "rings", "rows", "solve", "tiles", "write"}) {
    ASSERT_EQ(tiles_on(2, {"--levels", "1"}).exit_code, 0);
    const auto old = files_below(path("t"));
    EXPECT_NE(tiles_on(3, {"--levels", "2"}, std::string("1:") + phase).exit_code, 0) << phase;
    EXPECT_TRUE(files_below(path("t")) == old) << phase;
    const ProcessResult result =
        tiles_on(2, {"--levels", "2", "--resume", "--report", path("r.json")});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(files_below(path("t")) == undisturbed) << phase;
    EXPECT_TRUE(read("t.json") == document) << phase;
    resumed += read_report()["outputs"][0]["resumed_blocks"].get<std::int64_t>();
  }
  EXPECT_GT(resumed, 0);
}

TEST_F(MpiTiles, FullDisksLeaveTheOldSet) {
  ASSERT_EQ(tiles_on(2).exit_code, 0);
  const auto old = files_below(path("t"));
  const std::string document = read("t.json");
  // No file of a rank beyond 4 KB: those that Open MPI makes for itself are left out.
  write("small.sh", "ulimit -f 4; trap '' XFSZ; exec \"$@\"\n");
  const std::vector<std::string> small{"--mca", "btl", "self,tcp", "bash", path("small.sh")};
  const ProcessResult full = tiles_on(2, {"--levels", "3"}, {}, small);
  EXPECT_EQ(full.exit_code, 7) << full.err;
  EXPECT_THAT(full.err, HasSubstr("cannot write"));
  EXPECT_EQ(files_below(path("t")), old);
  EXPECT_EQ(read("t.json"), document);
  const std::string cage = write("c.ply", "old");
  const ProcessResult cut =
      on(2, {"fit", torus_, "--cage", cage, "-f", "--block-vertices", "50"}, {}, small);
  EXPECT_EQ(cut.exit_code, 7) << cut.err;
  EXPECT_TRUE(read("c.ply") == "old");
  EXPECT_EQ(names(), (std::vector<std::string>{"c.ply", "small.sh", "t", "t.json", "torus.obj"}));
}

TEST_F(MpiTiles, ForceReplacesASetAndNothingElse) {
  ASSERT_EQ(tiles_on(2).exit_code, 0);
  EXPECT_EQ(on(2, {"fit", torus_, "-o", path("t.json")}).exit_code, 7);
  write("t/readme.txt", "mine");
  const ProcessResult kept = tiles_on(2);
  EXPECT_EQ(kept.exit_code, 7);
  EXPECT_THAT(kept.err, HasSubstr("t/readme.txt"));
  EXPECT_EQ(read("t/readme.txt"), "mine");
}

TEST_F(MpiCommand, AHangingRankIsEndedByTheWatchdog) {
  const ProcessResult result =
      on(3, {"fit", torus_, "--cage", path("c.ply"), "--watchdog", "2", "--block-vertices", "50"},
         "1:faces:stop");
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("has come no further for 2 s"));
  EXPECT_FALSE(exists("c.ply"));
}

// planish-mpi run: scene files over ranks.
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
