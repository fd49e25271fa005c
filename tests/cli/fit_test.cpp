#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <random>
#include <sstream>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class FitCommand : public FolderTest {
 protected:
  std::string plate_ = write("plate.obj", bumpy_plate_obj(8));
  std::string torus_ = write("torus.obj", torus_obj(12));
};

TEST_F(FitCommand, WritesEveryFormat) {
  const ProcessResult result =
      run_planish({"fit", torus_, "-o", path("t.glb"), "-o", path("t.gltf"), "-o", path("t2.obj"),
                   "-o", path("t.ply"), "-o", path("t.off"), "--cage", path("c.obj")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(names(), ElementsAre("c.obj", "plate.obj", "t.bin", "t.glb", "t.gltf", "t.off",
                                   "t.ply", "t2.obj", "torus.obj"));
  EXPECT_EQ(read("t.glb").substr(0, 4), "glTF");
  EXPECT_EQ(read("t.ply").substr(0, 4), "ply\n");
  EXPECT_EQ(read("t.off").substr(0, 3), "OFF");
  EXPECT_EQ(read_json("t.gltf")["buffers"][0]["uri"], "t.bin");
  EXPECT_THAT(result.out, IsEmpty());
  EXPECT_THAT(result.err, HasSubstr("144 vertices, 144 faces (closed, genus 1)"));
}

// What went in, what was taken and why, what came out; how it was computed with -v.
TEST_F(FitCommand, SaysThreeLinesOfAGoodMesh) {
  const ProcessResult result = run_planish({"fit", torus_, "-o", path("t.glb")});
  EXPECT_EQ(std::ranges::count(result.err, '\n'), 3) << result.err;
  EXPECT_THAT(result.err,
              AllOf(HasSubstr("torus.obj: 144 vertices, "), HasSubstr("\n  surface     fair: "),
                    HasSubstr("; normals off by "), HasSubstr("\n  wrote       ")));
  const ProcessResult full = run_planish({"fit", torus_, "-o", path("t.glb"), "-f", "-v"});
  EXPECT_THAT(full.err, AllOf(HasSubstr("\n  method      "), HasSubstr("\n  max error   "),
                              HasSubstr("\n  device      "), HasSubstr("\n  time        "),
                              HasSubstr("\n  chosen      fair: ")));
}

// Figures of a level that is in no file say so.
TEST_F(FitCommand, NamesTheLevelOfFiguresThatIsNotWritten) {
  const auto said = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> arguments{"fit", torus_, "-o", path("t.glb"), "-f"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return run_planish(arguments).err;
  };
  EXPECT_THAT(said({"--levels", "2"}), HasSubstr("rms from the input's faces\n"));
  EXPECT_THAT(said({"--levels", "1"}), HasSubstr("rms from the input's faces\n"));
  EXPECT_THAT(said({"--chord-error", "1e-2"}),
              HasSubstr("rms from the input's faces at level 1\n"));
}

TEST_F(FitCommand, TheCageKeepsVertexOrderAndFaces) {
  ASSERT_EQ(run_planish({"fit", torus_, "--cage", path("c.obj")}).exit_code, 0);
  const auto faces = [](const std::string& obj) { return obj.substr(obj.find("\nf ")); };
  EXPECT_EQ(faces(read("c.obj")), faces(read("torus.obj")));
}

TEST_F(FitCommand, TheSameBytesFromRunToRunOnTheCpu) {
  for (const char* folder : {"a", "b"}) {
    write(std::string(folder) + "/keep", "");
    ASSERT_EQ(
        run_planish({"fit", plate_, "--device", "cpu", "-o", path(std::string(folder) + "/p.glb"),
                     "-o", path(std::string(folder) + "/p.gltf"), "-o",
                     path(std::string(folder) + "/p.ply"), "--cage",
                     path(std::string(folder) + "/c.obj")})
            .exit_code,
        0);
  }
  for (const char* name : {"p.glb", "p.gltf", "p.bin", "p.ply", "c.obj"}) {
    EXPECT_FALSE(read(std::string("a/") + name).empty());
    EXPECT_EQ(read(std::string("a/") + name), read(std::string("b/") + name)) << name;
  }
}

TEST_F(FitCommand, ReadsStdinAndWritesAGlbToStdout) {
  PlanishProcess::Options options;
  options.input = read("torus.obj");
  const ProcessResult piped =
      run_planish({"fit", "-", "--input-format", "obj", "-o", "-", "--device", "cpu"}, options);
  ASSERT_EQ(piped.exit_code, 0) << piped.err;
  EXPECT_EQ(piped.out.substr(0, 4), "glTF");
  // The names of the meshes differ ("stdin"), the numbers do not.
  ASSERT_EQ(run_planish({"fit", torus_, "-o", path("stdin.glb"), "--device", "cpu"}).exit_code, 0);
  const std::string file = read("stdin.glb");
  const auto chunk = [](const std::string& glb) { return glb.substr(glb.find("BIN")); };
  EXPECT_EQ(chunk(piped.out), chunk(file));
}

TEST_F(FitCommand, AClosedPipeLeavesNoFile) {
  PlanishProcess::Options options;
  options.closed_stdout = true;
  const ProcessResult result =
      run_planish({"fit", torus_, "-o", "-", "--cage", path("c.obj")}, options);
  EXPECT_EQ(result.signal, SIGPIPE);
  EXPECT_FALSE(exists("c.obj"));
}

TEST_F(FitCommand, NotConvergingWritesFlaggedFilesAndExitsFive) {
  const ProcessResult result =
      run_planish({"fit", plate_, "-o", path("p.gltf"), "--report", path("r.json"),
                   "--max-iterations", "1", "--interpolation", "progressive"});
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.err, HasSubstr("not converged (iteration-limit)"));
  EXPECT_EQ(read_json("p.gltf")["asset"]["extras"]["converged"], false);
  const nlohmann::json report = read_json("r.json");
  EXPECT_EQ(report["exit_code"], 5);
  EXPECT_EQ(report["solve"]["converged"], false);
  EXPECT_EQ(report["solve"]["stop_reason"], "iteration-limit");
  EXPECT_EQ(report["solve"]["iterations"], 1);
}

TEST_F(FitCommand, ExtrasSayWhatWasDone) {
  ASSERT_EQ(run_planish({"fit", torus_, "-o", path("t.gltf"), "--preset", "paper", "--levels", "1",
                         "--report", path("r.json")})
                .exit_code,
            0);
  const nlohmann::json extras = read_json("t.gltf")["asset"]["extras"];
  EXPECT_EQ(extras["converged"], true);
  EXPECT_EQ(extras["weights"], "averaged");
  EXPECT_EQ(extras["solver"], "plain");
  EXPECT_EQ(extras["level"], 1);
  const nlohmann::json error = read_json("r.json")["solve"]["error"];
  EXPECT_EQ(extras["max_error"], error["max"]);
  EXPECT_LE(error["max"], 1e-6);
  EXPECT_LT(error["rms"], error["max"]);  // so that one does not stand for the other
}

TEST_F(FitCommand, FlagsOverrideThePreset) {
  ASSERT_EQ(run_planish({"fit", torus_, "--solver", "chebyshev", "--preset", "paper", "--report",
                         path("r.json")})
                .exit_code,
            0);
  EXPECT_EQ(read_json("r.json")["solve"]["solver"], "chebyshev");
  EXPECT_EQ(read_json("r.json")["solve"]["weights"], "averaged");
}

TEST_F(FitCommand, OpenSurfacesAreDoubleSided) {
  ASSERT_EQ(run_planish({"fit", plate_, "-o", path("p.gltf")}).exit_code, 0);
  ASSERT_EQ(run_planish({"fit", torus_, "-o", path("t.gltf")}).exit_code, 0);
  EXPECT_EQ(read_json("p.gltf")["materials"][0].value("doubleSided", false), true);
  EXPECT_EQ(read_json("t.gltf")["materials"][0].value("doubleSided", false), false);
}

TEST_F(FitCommand, FarModelsAreStoredAboutTheirCentre) {
  std::string far_cube = cube_obj();
  for (std::size_t at = far_cube.find("v "); at != std::string::npos;
       at = far_cube.find("v ", at + 2)) {
    far_cube.insert(at + 2, "100000");  // 0 and 1 become 1000000 and 1000001
  }
  const std::string input = write("far.obj", far_cube);
  ASSERT_EQ(run_planish({"fit", input, "-o", path("f.gltf"), "--report", path("r.json")}).exit_code,
            0);
  const nlohmann::json document = read_json("f.gltf");
  EXPECT_EQ(document["nodes"][0]["translation"], nlohmann::json({1000000.5, 0.5, 0.5}));
  // In float32 about the origin the error would be 0.03 of the edge.
  EXPECT_LT(read_json("r.json")["outputs"][0]["as_written_error"].get<double>(), 1e-6);
}

TEST_F(FitCommand, ZUpIsTurnedUpright) {
  ASSERT_EQ(run_planish({"fit", plate_, "-o", path("y.gltf")}).exit_code, 0);
  ASSERT_EQ(run_planish({"fit", plate_, "-o", path("z.gltf"), "--up", "z"}).exit_code, 0);
  const nlohmann::json as_given = read_json("y.gltf")["accessors"][0];
  const nlohmann::json upright = read_json("z.gltf")["accessors"][0];
  // (x, y, z) becomes (x, z, -y).
  EXPECT_EQ(upright["max"][0], as_given["max"][0]);
  EXPECT_EQ(upright["max"][1], as_given["max"][2]);
  EXPECT_EQ(upright["max"][2].get<double>(), -as_given["min"][1].get<double>());
  EXPECT_EQ(upright["min"][2].get<double>(), -as_given["max"][1].get<double>());
}

TEST_F(FitCommand, CgOnAnOpenMeshIsAUsageError) {
  const ProcessResult result = run_planish({"fit", plate_, "-o", path("p.glb"), "--solver", "cg"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("closed"));
  EXPECT_EQ(run_planish({"fit", torus_, "-o", path("t.glb"), "--solver", "cg"}).exit_code, 0);
}

TEST_F(FitCommand, UnusedVerticesAreToldAndStay) {
  const std::string input = write(
      "u.obj", "v 7 8 9\n" + [] {
        std::string cube = cube_obj();
        // Every face names the vertices one further on.
        std::string shifted;
        for (const char c : cube.substr(cube.find("f "))) {
          shifted += c >= '1' && c <= '8' ? static_cast<char>(c + 1) : c;
        }
        return cube.substr(0, cube.find("f ")) + shifted;
      }());
  const ProcessResult result = run_planish({"fit", input, "--cage", path("c.obj")});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("1 of 9 vertices belongs to no face (0)"));
  EXPECT_THAT(read("c.obj"), HasSubstr("\nv 7 8 9\n"));
}

TEST_F(FitCommand, QuietSaysNothingWhenAllIsWell) {
  const ProcessResult result = run_planish({"fit", torus_, "-o", path("t.glb"), "-q"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, IsEmpty());
}

TEST_F(FitCommand, ColorIsOffWhereNobodySeesIt) {
  const std::vector<std::string> arguments{"fit", plate_, "-o", path("p.glb"), "--solver", "cg"};
  EXPECT_THAT(run_planish(arguments).err, testing::Not(HasSubstr("\033")));
}

TEST_F(FitCommand, ProgressAsJsonNamesTheSteps) {
  const ProcessResult result = run_planish(
      {"fit", torus_, "-o", path("t.glb"), "--progress", "json", "--log-level", "error"});
  ASSERT_EQ(result.exit_code, 0);
  std::istringstream lines(result.err);
  std::vector<std::string> steps;
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json entry = nlohmann::json::parse(line);
    EXPECT_EQ(entry["job"], "torus");
    EXPECT_GE(entry["fraction"], 0.0);
    EXPECT_LE(entry["fraction"], 1.0);
    steps.push_back(entry["step"]);
  }
  EXPECT_THAT(steps, testing::IsSupersetOf({"read", "stencils"}));
}

// How long the share stood still at most, as a part of the whole job, and in which step.
struct LongestWait {
  double part = 0;
  std::string step;
};

LongestWait longest_wait(const std::string& progress, double seconds) {
  std::istringstream lines(progress);
  double risen_at = 0, share = 0;
  LongestWait longest;
  const auto wait_until = [&](double now, const std::string& step) {
    const double part = (now - risen_at) / seconds;
    if (part > longest.part) longest = {part, step};
  };
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json entry = nlohmann::json::parse(line);
    EXPECT_GE(entry["share"], share);
    if (entry["share"] <= share) continue;
    wait_until(entry["seconds"], entry["step"]);
    risen_at = entry["seconds"];
    share = entry["share"];
  }
  EXPECT_GT(share, 0.9);
  wait_until(seconds, "the end");
  return longest;
}

// Whoever watches the share sees it move while time passes: no wait is a large part of the whole.
TEST_F(FitCommand, TheShareOfProgressMovesWithTime) {
  const std::string large = write("large.obj", torus_obj(350));
  const ProcessResult result =
      run_planish({"fit", large, "-o", path("l.glb"), "--report", path("l.json"), "--progress",
                   "json", "--log-level", "error"});
  ASSERT_EQ(result.exit_code, 0);
  const double seconds = read_json("l.json")["timing_ms"]["total"].get<double>() / 1000;
  const LongestWait longest = longest_wait(result.err, seconds);
  EXPECT_LT(longest.part, std::max(1.0 / seconds, 0.3)) << longest.step;
}

// The mesher is a program of its own, and takes most of the time.
#ifdef PLANISH_HAS_MESHER
TEST_F(FitCommand, TheShareOfACloudMovesWithTime) {
  std::ostringstream cloud;
  std::mt19937 random(4);
  for (int i = 0; i < 100'000; ++i) {
    const double u = 2 * M_PI * random() * 0x1p-32, v = 2 * M_PI * random() * 0x1p-32;
    const double ring = 1 + 0.4 * std::cos(v);
    cloud << ring * std::cos(u) << ' ' << ring * std::sin(u) << ' ' << 0.4 * std::sin(v) << '\n';
  }
  const ProcessResult result =
      run_planish({"fit", write("cloud.xyz", cloud.str()), "-o", path("c.glb"), "--report",
                   path("c.json"), "--progress", "json", "--log-level", "error"});
  ASSERT_EQ(result.exit_code, 0);
  const double seconds = read_json("c.json")["timing_ms"]["total"].get<double>() / 1000;
  const LongestWait longest = longest_wait(result.err, seconds);
  EXPECT_LT(longest.part, 0.1) << longest.step;
}
#endif

}  // namespace
}  // namespace planish::test
