#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <random>
#include <sstream>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "planish/job/fit_file.h"
#include "planish/pipeline/verify_cage.h"
#include "support/calls.h"

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

// What fit_file() gives besides files.

using FitFile = FolderTest;

// A roof over two faces whose corners have the normals of their face, or of the vertex.
std::string roof_obj(bool is_split) {
  const std::string a = "1", b = is_split ? "2" : "1";
  return "v 0 0 0\nv 1 0 1\nv 2 0 0\nv 0 3 0\nv 1 3 1\nv 2 3 0\nvn -1 0 1\nvn 1 0 1\nf 1//" + a +
         " 2//" + a + " 5//" + a + " 4//" + a + "\nf 2//" + b + " 3//" + b + " 6//" + b + " 5//" +
         b + "\n";
}

// Of meshes and of points; a name that is none, and a value, are refused by what they are called.
TEST(SettingsOf, NamesOfBothTablesAreTaken) {
  const Settings settings = settings_of({{"target_vertices", "100"}, {"polish", "3"}});
  EXPECT_EQ(settings.polish_steps, 3);
  EXPECT_EQ(settings.points.target_vertices, 100);
  const auto refusal = [](const char* name) {
    return message_of(ErrorCode::InvalidArgument, [&] { (void)settings_of({{name, "many"}}); });
  };
  EXPECT_EQ(refusal("polishing"), "polishing: there is no such option");
  EXPECT_THAT(refusal("polish"), HasSubstr("--polish: \"many\" is no whole number"));
  EXPECT_THAT(refusal("target_vertices"), HasSubstr("--target-vertices: \"many\""));
}

TEST_F(FitFile, SplitNormalsAreCreasesWhereAsked) {
  const std::string roof = write("roof.obj", roof_obj(true));
  FitFileOptions options;
  options.settings = settings_of({{"creases", "normals"}});
  const FileFit sharp = fit_file(roof, path("sharp.glb"), options);
  EXPECT_EQ(sharp.fitted.fit.sharp_edge_count, 7);  // the ridge beside the border
  EXPECT_EQ(sharp.fitted.creases(), "normals");
  EXPECT_TRUE(sharp.fitted.warnings.empty());
  FitFileOptions rounded;
  rounded.settings.creases.chooses = false;
  EXPECT_EQ(fit_file(roof, path("smooth.glb"), rounded).fitted.fit.sharp_edge_count, 6);
  const FileFit none = fit_file(write("smooth.obj", roof_obj(false)), path("none.glb"), options);
  ASSERT_EQ(none.fitted.warnings.size(), 1u);
  EXPECT_EQ(none.fitted.warnings[0].code, "no-split-normals");
}

TEST_F(FitFile, MendsWhatTheCommandMends) {
  // The second face is turned the wrong way round.
  const std::string input = write("turned.obj",
                                  "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 1\nv 2 1 1\n"
                                  "f 1 2 3 4\nf 2 3 6 5\n");
  EXPECT_EQ(fit_file(input, path("mended.glb")).fitted.warnings.size(), 1u);
  FitFileOptions options;
  options.settings.repair = RepairChoice::None;
  const std::string message = message_of(ErrorCode::UnusableMesh,
                                         [&] { (void)fit_file(input, path("none.glb"), options); });
  EXPECT_THAT(message, HasSubstr("turned.obj: "));
  EXPECT_THAT(message, HasSubstr("repair() mends this"));
}

TEST_F(FitFile, ItsCageIsConfirmed) {
  const std::string input = write("plate.obj", bumpy_plate_obj(8));
  FitFileOptions options;
  options.cage = path("cage.obj");
  const FileFit done = fit_file(input, path("plate.glb"), options);
  EXPECT_EQ(done.fitted.options.method, InterpolationMethod::Fair) << "as without the cage";
  EXPECT_EQ(read("plate.glb"), (fit_file(input, path("alone.glb")), read("alone.glb")));
  const Verification found =
      verify_cage(read_mesh(path("cage.obj")).mesh, read_mesh(input).mesh, {});
  EXPECT_TRUE(found.confirmed) << found.error.max;
  EXPECT_EQ(found.vertex_count, 81);
  PolygonMesh moved = read_mesh(path("cage.obj")).mesh;
  moved.positions[3].z += 0.1;
  EXPECT_FALSE(verify_cage(moved, read_mesh(input).mesh, {}).confirmed);
}

TEST_F(FitFile, ErrorsNameTheRemedy) {
  const std::string input = write("plate.obj", bumpy_plate_obj(4));
  const std::string cloud = write("cloud.ply",
                                  "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                  "property float y\nproperty float z\nend_header\n0 0 0\n");
  const auto message = [&](ErrorCode code, const std::string& from, const std::string& to,
                           int level = 2) {
    FitFileOptions options;
    options.settings.set_levels({level});
    return message_of(code, [&] { (void)fit_file(from, to, options); });
  };
  EXPECT_THAT(message(ErrorCode::InvalidArgument, input, path("a.iges")),
              HasSubstr("is written as .glb, .gltf"));
  EXPECT_THAT(message(ErrorCode::InvalidArgument, input, input), HasSubstr("is the input itself"));
  EXPECT_THAT(message(ErrorCode::InvalidArgument, input, path("a.glb"), 9), HasSubstr("9"));
  EXPECT_THAT(message(ErrorCode::UnusableMesh, cloud, path("a.glb")), HasSubstr("cloud.ply"));
  EXPECT_THAT(message(ErrorCode::UnreadableInput, path("none.obj"), path("a.glb")),
              HasSubstr("none.obj"));
  EXPECT_FALSE(std::filesystem::exists(path("a.glb")));
}

// A bumpy sheet.
std::string sheet() {
  std::ostringstream obj;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x)
      obj << "v " << x << ' ' << y << ' ' << 0.1 * std::sin(12.9898 * x + 78.233 * y) << '\n';
  for (int y = 0; y < 11; ++y)
    for (int x = 0; x < 11; ++x)
      obj << "f " << 12 * y + x + 1 << ' ' << 12 * y + x + 2 << ' ' << 12 * y + x + 14 << ' '
          << 12 * y + x + 13 << '\n';
  return obj.str();
}

class Within : public FolderTest {};

TEST_F(Within, IsSaidReportedAndVerified) {
  const std::string input = write("sheet.obj", sheet());
  for (const std::string method : {"progressive", "fair"}) {
    const ProcessResult fit =
        run_planish({"fit", input, "--within", "0.003", "--interpolation", method, "--cage",
                     path("cage.obj"), "-o", path("s.glb"), "--report", path("r.json"), "-f"});
    ASSERT_EQ(fit.exit_code, 0) << fit.err;
    EXPECT_THAT(fit.err, HasSubstr("within      0.003 of the diagonal: vertices are left by"));
    EXPECT_EQ(fit.err.find("rounding"), std::string::npos) << fit.err;
    const nlohmann::json within = read_json("r.json")["solve"]["within"];
    EXPECT_EQ(within["allowed"], 0.003);
    EXPECT_EQ(within["noise"], nullptr);
    EXPECT_LT(within["bending_after"], 0.9 * within["bending_before"].get<double>());

    EXPECT_EQ(run_planish({"verify", path("cage.obj"), input}).exit_code, 0);
    const ProcessResult verified =
        run_planish({"verify", path("cage.obj"), input, "--within", "0.0029", "--json"});
    EXPECT_EQ(verified.exit_code, 5) << verified.out;
    const nlohmann::json found = nlohmann::json::parse(verified.out);
    EXPECT_NEAR(found["error"]["max"].get<double>(), within["distance"]["max"].get<double>(), 2e-6);
  }
}

// The header says what was allowed where the noise decided.
TEST_F(Within, MeasuredIsVerifiedToo) {
  const std::string input = write("sheet.obj", sheet());
  const ProcessResult fit = run_planish(
      {"fit", input, "--within", "auto", "--cage", path("cage.obj"), "--report", path("r.json")});
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  EXPECT_THAT(fit.err, HasSubstr("(the noise is "));
  EXPECT_GT(read_json("r.json")["solve"]["within"]["noise"], 1e-3);
  EXPECT_EQ(run_planish({"verify", path("cage.obj"), input}).exit_code, 0);
  EXPECT_EQ(run_planish({"verify", path("cage.obj"), input, "--within", "auto"}).exit_code, 2);
}

TEST_F(Within, RefusesWhatMeansNothing) {
  const std::string input = write("sheet.obj", sheet());
  const auto error = [&](const std::string& value) {
    const ProcessResult result =
        run_planish({"fit", input, "-o", path("s.glb"), "--within", value});
    EXPECT_EQ(result.exit_code, 2) << value;
    return result.err;
  };
  EXPECT_THAT(error("1e-7"), HasSubstr("--within: 1e-07 is not above --tolerance 1e-06"));
  for (const char* value : {"0.1", "-0.001", "nan", "Auto", "0.01x", "inf"})
    EXPECT_THAT(error(value), HasSubstr("is neither; auto, 0, or a fraction")) << value;
}

// --scheme catmull-clark and loop from input to files.

const std::string kScenes = PLANISH_SCENES;

class SchemeFlag : public FolderTest {
 protected:
  // Fits to all kinds of files and has the cage verified.
  nlohmann::json expect_fit_and_verify(const std::string& input, const std::string& scheme,
                                       const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"fit",      input,          "--scheme", scheme,
                                       "-o",       path("s.glb"),  "-o",       path("s.ply"),
                                       "--levels", "2,0",          "--cage",   path("c.obj"),
                                       "--report", path("r.json"), "-f"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult fitted = run_planish(arguments);
    EXPECT_EQ(fitted.exit_code, 0) << fitted.err;
    EXPECT_THAT(fitted.err, HasSubstr(scheme));
    EXPECT_THAT(read("c.obj"), HasSubstr("# planish scheme=" + scheme));
    const ProcessResult verified = run_planish({"verify", path("c.obj"), input, "--json"});
    EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
    EXPECT_EQ(nlohmann::json::parse(verified.out)["scheme"], scheme);
    nlohmann::json report = read_json("r.json");
    EXPECT_EQ(report["solve"]["scheme"], scheme);
    EXPECT_EQ(report["solve"]["weights"], nullptr);
    EXPECT_TRUE(report["solve"]["converged"]);
    for (const auto& output : report["outputs"]) {
      EXPECT_LE(output["as_written_error"], 1.01e-6) << output["path"];
    }
    return report;
  }
};

TEST_F(SchemeFlag, CatmullClarkInterpolatesTheGoblet) {
  const nlohmann::json report = expect_fit_and_verify(kScenes + "/goblet.obj", "catmull-clark");
  EXPECT_GT(report["outputs"][0]["quads"], 0);
  EXPECT_EQ(report["outputs"][0]["triangles"],
            2 * report["outputs"][0]["quads"].get<std::int64_t>());
  const ProcessResult as_doo_sabin =
      run_planish({"verify", path("c.obj"), kScenes + "/goblet.obj", "--scheme", "doo-sabin"});
  EXPECT_EQ(as_doo_sabin.exit_code, 5);
}

TEST_F(SchemeFlag, LoopInterpolatesATriangleMesh) {
  const nlohmann::json report = expect_fit_and_verify(kScenes + "/rocker_arm_scan.obj", "loop");
  EXPECT_EQ(report["outputs"][0]["quads"], 0);
  EXPECT_EQ(report["outputs"][0]["triangles"], 16 * report["input"]["faces"].get<std::int64_t>());
  EXPECT_THAT(read("s_LOD0.glb"), HasSubstr("\"scheme\":\"loop\""));
}

TEST_F(SchemeFlag, RunsOnVulkanAsOnTheCpu) {
  if (run_planish({"fit", write("t.obj", torus_obj(4)), "-o", path("t.glb"), "--device", "vulkan"})
          .exit_code == 6) {
    GTEST_SKIP() << "no Vulkan device";
  }
  for (const std::string scheme : {"catmull-clark", "loop"}) {
    const std::string input =
        scheme == "loop" ? kScenes + "/icosphere.obj" : write("plate.obj", bumpy_plate_obj(9));
    const auto on_cpu = expect_fit_and_verify(input, scheme, {"--device", "cpu"});
    const auto on_vulkan = expect_fit_and_verify(input, scheme, {"--device", "vulkan"});
    EXPECT_EQ(on_cpu["solve"]["iterations"], on_vulkan["solve"]["iterations"]);
    EXPECT_NE(on_vulkan["device"]["kind"], "cpu");
  }
}

TEST_F(SchemeFlag, CreasesOfEverySharpnessHold) {
  std::string obj = bumpy_plate_obj(6);
  obj += "t crease 2/1/0 8 9 3.5\nt crease 2/1/0 9 10 10\nt corner 1/1/0 24 2\n";
  expect_fit_and_verify(write("tagged.obj", obj), "catmull-clark");
  expect_fit_and_verify(write("tagged.obj", obj), "catmull-clark",
                        {"--boundary", "edge-and-corner"});
  expect_fit_and_verify(write("tagged.obj", obj), "catmull-clark", {"--creases", "auto:5"});
}

TEST_F(SchemeFlag, ACubeOutOfTrueHasNoCatmullClarkSurface) {
  std::string obj = cube_obj();
  obj.replace(obj.find("v 1 1 1"), 7, "v 1 1 1.3");
  const ProcessResult result =
      run_planish({"fit", write("cube.obj", obj), "--scheme", "catmull-clark", "-o", path("c.glb"),
                   "--cage", path("cage.obj"), "--report", path("r.json")});
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.err, HasSubstr("not converged (singular)"));
  EXPECT_THAT(result.err, HasSubstr("take --scheme doo-sabin"));
  EXPECT_THAT(read("c.glb"), HasSubstr("\"converged\":false"));
  const nlohmann::json report = read_json("r.json");
  EXPECT_EQ(report["exit_code"], 5);
  EXPECT_EQ(report["solve"]["converged"], false);
  EXPECT_EQ(report["solve"]["stop_reason"], "singular");
  EXPECT_EQ(run_planish({"verify", path("cage.obj"), path("cube.obj")}).exit_code, 5);
}

TEST_F(SchemeFlag, LoopNamesTheFirstFaceThatIsNoTriangle) {
  const ProcessResult result = run_planish(
      {"fit", write("plate.obj", bumpy_plate_obj(3)), "--scheme", "loop", "-o", path("p.glb")});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("plate.obj: face 0 has 4 corners, and Loop subdivision knows "
                                    "triangles only; split the faces into triangles, or take "
                                    "catmull-clark or doo-sabin"));
  EXPECT_FALSE(exists("p.glb"));
}

TEST_F(SchemeFlag, SceneFilesNameSchemes) {
  write("plate.obj", bumpy_plate_obj(5));
  write("s.json",
        R"({"version":1,"jobs":[{"input":"plate.obj","solve":{"scheme":"catmull-clark"},
            "outputs":[{"path":"p.glb"}],"report":"r.json"}]})");
  const ProcessResult result = run_planish({"run", path("s.json")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read_json("r.json")["solve"]["scheme"], "catmull-clark");
  EXPECT_THAT(result.out + result.err, HasSubstr("catmull-clark"));
}

TEST_F(SchemeFlag, DryRunCountsFaces) {
  const ProcessResult result = run_planish({"fit", kScenes + "/icosphere.obj", "--scheme", "loop",
                                            "-o", path("i.glb"), "--levels", "2", "--dry-run"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("81,920 triangles)"));
}

}  // namespace
}  // namespace planish::test
