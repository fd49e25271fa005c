#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <random>
#include <sstream>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/core/error.h"
#include "planish/job/fit_file.h"
#include "support/calls.h"

namespace planish::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class FitCommand : public FolderTest {
 protected:
  std::string plate_ = write("plate.obj", bumpy_plate_obj(8));
  std::string torus_ = write("torus.obj", torus_obj(12));
};

TEST_F(FitCommand, WritesEveryFormat) {
  const ProcessResult result =
      run("fit torus.obj -o t.glb -o t.gltf -o t2.obj -o t.ply -o t.off --cage c.obj");
  EXPECT_THAT(names(), ElementsAre("c.obj", "plate.obj", "t.bin", "t.glb", "t.gltf", "t.off",
                                   "t.ply", "t2.obj", "torus.obj"));
  EXPECT_EQ(read("t.glb").substr(0, 4), "glTF");
  EXPECT_EQ(read("t.ply").substr(0, 4), "ply\n");
  EXPECT_EQ(read("t.off").substr(0, 3), "OFF");
  EXPECT_EQ(read_json("t.gltf")["buffers"][0]["uri"], "t.bin");
  EXPECT_EQ(result.out, "");
  // The cage keeps the order of vertices and faces.
  const auto faces = [](const std::string& obj) { return obj.substr(obj.find("\nf ")); };
  EXPECT_EQ(faces(read("c.obj")), faces(read("torus.obj")));
}

// What went in, what was taken and why, what came out; how it was computed with -v.
TEST_F(FitCommand, SaysThreeLinesOfAGoodMesh) {
  run("fit torus.obj -o t.glb");
  EXPECT_EQ(lines_of(said_).size(), 3u) << said_;
  EXPECT_THAT(said_, AllOf(HasSubstr("torus.obj: 144 vertices, 144 faces (closed, genus 1)"),
                           HasSubstr("\n  surface     fair: "), HasSubstr("; normals off by "),
                           HasSubstr("\n  wrote       "), testing::Not(HasSubstr("bound "))));
  run("fit torus.obj -o t.glb -f -v");
  for (const char* part :
       {"method      ", "max error   ", "device      ", "time        ", "chosen      fair: "})
    EXPECT_THAT(said_, HasSubstr(std::string("\n  ") + part));
  run("fit torus.obj -o t.glb -f -v --interpolation progressive");
  for (const char* part : {"threads ", "bound ", "errors ", "memory "})
    EXPECT_THAT(said_, HasSubstr(part));
  run("fit torus.obj -o t.glb -f -q");
  EXPECT_EQ(said_, "");
}

// Figures of a level that is in no file say so.
TEST_F(FitCommand, NamesTheLevelOfFiguresThatIsNotWritten) {
  for (const auto& [fineness, level] : {std::pair{"--levels 2", "\n"},
                                        {"--levels 1", "\n"},
                                        {"--chord-error 1e-2", " at level 1\n"}}) {
    run(std::string("fit torus.obj -o t.glb -f ") + fineness);
    EXPECT_THAT(said_, HasSubstr(std::string("rms from the input's faces") + level));
  }
}

TEST_F(FitCommand, TheSameBytesFromRunToRun) {
  for (const std::string folder : {"a/", "b/"}) {
    write(folder + "keep", "");
    run("fit plate.obj -o " + folder + "p.glb -o " + folder + "p.gltf -o " + folder +
        "p.ply --cage " + folder + "c.obj");
  }
  for (const std::string name : {"p.glb", "p.gltf", "p.bin", "p.ply", "c.obj"}) {
    EXPECT_FALSE(read("a/" + name).empty());
    EXPECT_EQ(read("a/" + name), read("b/" + name)) << name;
  }
}

TEST_F(FitCommand, ReadsStdinAndWritesAGlbToStdout) {
  const std::string piped =
      run("fit - --input-format obj -o -", 0, {.input = read("torus.obj")}).out;
  EXPECT_EQ(piped.substr(0, 4), "glTF");
  // The names of the meshes differ ("stdin"), the numbers do not.
  run("fit torus.obj -o stdin.glb");
  const auto chunk = [](const std::string& glb) { return glb.substr(glb.find("BIN")); };
  EXPECT_EQ(chunk(piped), chunk(read("stdin.glb")));
}

TEST_F(FitCommand, NotConvergingWritesFlaggedFilesAndExitsFive) {
  const json report =
      report_of("fit plate.obj -o p.gltf --max-iterations 1 --interpolation progressive", 5);
  EXPECT_THAT(said_, HasSubstr("not converged (iteration-limit)"));
  EXPECT_EQ(read_json("p.gltf")["asset"]["extras"]["converged"], false);
  expect_values(report, {{"/exit_code", 5},
                         {"/solve/converged", false},
                         {"/solve/stop_reason", "iteration-limit"},
                         {"/solve/iterations", 1}});
}

TEST_F(FitCommand, ExtrasSayWhatWasDone) {
  const json report = report_of("fit torus.obj -o t.gltf --preset paper --levels 1");
  const json extras = read_json("t.gltf")["asset"]["extras"], error = report["solve"]["error"];
  expect_values(
      extras,
      {{"/converged", true}, {"/weights", "averaged"}, {"/solver", "plain"}, {"/level", 1}});
  EXPECT_EQ(extras["max_error"], error["max"]);
  EXPECT_LE(error["max"], 1e-6);
  EXPECT_LT(error["rms"], error["max"]);  // so that one does not stand for the other
}

TEST_F(FitCommand, FlagsOverrideThePreset) {
  const json solve = report_of("fit torus.obj --solver chebyshev --preset paper")["solve"];
  expect_values(solve, {{"/solver", "chebyshev"}, {"/weights", "averaged"}});
  run("fit torus.obj -o t.glb --solver cg");
}

TEST_F(FitCommand, OpenSurfacesAreDoubleSided) {
  run("fit plate.obj -o p.gltf");
  run("fit torus.obj -o t.gltf");
  EXPECT_EQ(read_json("p.gltf")["materials"][0].value("doubleSided", false), true);
  EXPECT_EQ(read_json("t.gltf")["materials"][0].value("doubleSided", false), false);
}

TEST_F(FitCommand, FarModelsAreStoredAboutTheirCentre) {
  std::string far_cube = cube_obj();
  for (std::size_t at = far_cube.find("v "); at != std::string::npos;
       at = far_cube.find("v ", at + 2)) {
    far_cube.insert(at + 2, "100000");  // 0 and 1 become 1000000 and 1000001
  }
  write("far.obj", far_cube);
  const json report = report_of("fit far.obj -o f.gltf");
  EXPECT_EQ(read_json("f.gltf")["nodes"][0]["translation"], json({1000000.5, 0.5, 0.5}));
  // In float32 about the origin the error would be 0.03 of the edge.
  EXPECT_LT(report["outputs"][0]["as_written_error"].get<double>(), 1e-6);
}

TEST_F(FitCommand, ZUpIsTurnedUpright) {
  run("fit plate.obj -o y.gltf");
  run("fit plate.obj -o z.gltf --up z");
  const json as_given = read_json("y.gltf")["accessors"][0];
  const json upright = read_json("z.gltf")["accessors"][0];
  // (x, y, z) becomes (x, z, -y).
  EXPECT_EQ(upright["max"][0], as_given["max"][0]);
  EXPECT_EQ(upright["max"][1], as_given["max"][2]);
  EXPECT_EQ(upright["max"][2].get<double>(), -as_given["min"][1].get<double>());
  EXPECT_EQ(upright["min"][2].get<double>(), -as_given["max"][1].get<double>());
}

TEST_F(FitCommand, UnusedVerticesAreToldAndStay) {
  write("u.obj",
        "v 7 8 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 2 4 3\nf 2 3 5\nf 3 4 5\nf 4 2 5\n");
  run("fit u.obj --cage c.obj");
  EXPECT_THAT(said_, HasSubstr("1 of 5 vertices belongs to no face (0)"));
  EXPECT_THAT(read("c.obj"), HasSubstr("\nv 7 8 9\n"));
}

TEST_F(FitCommand, FlagsWithoutEffectAreTold) {
  const std::string begin = "fit torus.obj -f -o a.glb ", without = "without effect";
  run(begin + "--interpolation fair --solver cg --spacing even");
  EXPECT_THAT(said_, HasSubstr("warning: torus.obj: " + without + " here: --solver, --spacing"));
  run(begin + "--solver cg --interpolation progressive");
  EXPECT_THAT(said_, testing::Not(HasSubstr(without)));
  // Told by what is chosen.
  run(begin + "--solver cg");
  EXPECT_THAT(said_, HasSubstr(without + " here: --solver (the input is a mesh, the method fair)"));
}

TEST_F(FitCommand, ProgressAsJsonNamesTheSteps) {
  run("fit torus.obj -o t.glb --progress json --log-level error");
  std::vector<std::string> steps;
  for (const std::string& line : lines_of(said_)) {
    const json entry = json::parse(line);
    EXPECT_EQ(entry["job"], "torus");
    EXPECT_GE(entry["fraction"], 0.0);
    EXPECT_LE(entry["fraction"], 1.0);
    steps.push_back(entry["step"]);
  }
  EXPECT_THAT(steps, testing::IsSupersetOf({"read", "stencils"}));
}

// How long the share stood still at most, as a part of the whole job, and in which step.
struct LongestWait {
  double part = 0, seconds = 0;
  std::string step;
};

class ProgressShare : public FolderTest {
 protected:
  LongestWait longest_wait(const std::string& input) {
    const json report = report_of("fit " + input + " -o a.glb --progress json --log-level error");
    LongestWait longest;
    longest.seconds = report["timing_ms"]["total"].get<double>() / 1000;
    double risen_at = 0, share = 0;
    const auto wait_until = [&](double now, const std::string& step) {
      const double part = (now - risen_at) / longest.seconds;
      if (part > longest.part) longest = {part, longest.seconds, step};
    };
    for (const std::string& line : lines_of(said_)) {
      const json entry = json::parse(line);
      EXPECT_GE(entry["share"], share);
      if (entry["share"] <= share) continue;
      wait_until(entry["seconds"], entry["step"]);
      risen_at = entry["seconds"];
      share = entry["share"];
    }
    EXPECT_GT(share, 0.9);
    wait_until(longest.seconds, "the end");
    return longest;
  }
};

// Whoever watches the share sees it move while time passes: no wait is a large part of the whole.
TEST_F(ProgressShare, MovesWithTime) {
  write("large.obj", torus_obj(350));
  const LongestWait longest = longest_wait("large.obj");
  EXPECT_LT(longest.part, std::max(1.0 / longest.seconds, 0.3)) << longest.step;
}

// The mesher is a program of its own, and takes most of the time.
#ifdef PLANISH_HAS_MESHER
TEST_F(ProgressShare, OfACloudMovesWithTime) {
  std::ostringstream cloud;
  std::mt19937 random(4);
  for (int i = 0; i < 100'000; ++i) {
    const double u = 2 * M_PI * random() * 0x1p-32, v = 2 * M_PI * random() * 0x1p-32;
    const double ring = 1 + 0.4 * std::cos(v);
    cloud << ring * std::cos(u) << ' ' << ring * std::sin(u) << ' ' << 0.4 * std::sin(v) << '\n';
  }
  write("cloud.xyz", cloud.str());
  const LongestWait longest = longest_wait("cloud.xyz");
  EXPECT_LT(longest.part, 0.1) << longest.step;
}
#endif

// What fit_file() gives besides files.

using FitFile = FolderTest;

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

using Within = FolderTest;

TEST_F(Within, IsSaidReportedAndVerified) {
  write("sheet.obj", sheet());
  for (const std::string method : {"progressive", "fair"}) {
    const json within = report_of("fit sheet.obj --within 0.003 --interpolation " + method +
                                  " --cage cage.obj -o s.glb")["solve"]["within"];
    EXPECT_THAT(said_, HasSubstr("within      0.003 of the diagonal: vertices are left by"));
    EXPECT_THAT(said_, testing::Not(HasSubstr("rounding")));
    expect_values(within, {{"/allowed", 0.003}, {"/noise", nullptr}});
    EXPECT_LT(within["bending_after"], 0.9 * within["bending_before"].get<double>());
    run("verify cage.obj sheet.obj");
    const json found = printed("verify cage.obj sheet.obj --within 0.0029 --json", 5);
    EXPECT_NEAR(found["error"]["max"].get<double>(), within["distance"]["max"].get<double>(), 2e-6);
  }
}

// The header says what was allowed where the noise decided.
TEST_F(Within, MeasuredIsVerifiedToo) {
  write("sheet.obj", sheet());
  const json report = report_of("fit sheet.obj --within auto --cage cage.obj");
  EXPECT_THAT(said_, HasSubstr("(the noise is "));
  EXPECT_GT(report["solve"]["within"]["noise"], 1e-3);
  run("verify cage.obj sheet.obj");
}

// --scheme catmull-clark and loop from input to files.

class SchemeFlag : public FolderTest {
 protected:
  // Fits to all kinds of files and has the cage verified.
  json expect_fit_and_verify(const std::string& input, const std::string& scheme,
                             const std::string& more = "") {
    json report = report_of("fit " + input + " --scheme " + scheme +
                            " -o s.glb -o s.ply --levels 2,0 --cage c.obj" + more);
    EXPECT_THAT(said_, HasSubstr(scheme));
    EXPECT_THAT(read("c.obj"), HasSubstr("# planish scheme=" + scheme));
    EXPECT_EQ(printed("verify c.obj " + input + " --json")["scheme"], scheme);
    EXPECT_EQ(report["solve"]["scheme"], scheme);
    expect_values(report, {{"/solve/weights", nullptr}, {"/solve/converged", true}});
    for (const auto& output : report["outputs"])
      EXPECT_LE(output["as_written_error"], 1.01e-6) << output["path"];
    return report;
  }
};

TEST_F(SchemeFlag, CatmullClarkInterpolatesTheGoblet) {
  const json surface =
      expect_fit_and_verify(PLANISH_SCENES "/goblet.obj", "catmull-clark")["outputs"][0];
  EXPECT_GT(surface["quads"], 0);
  EXPECT_EQ(surface["triangles"], 2 * surface["quads"].get<std::int64_t>());
  run("verify c.obj " PLANISH_SCENES "/goblet.obj --scheme doo-sabin", 5);
}

TEST_F(SchemeFlag, LoopInterpolatesATriangleMesh) {
  const json report = expect_fit_and_verify(PLANISH_SCENES "/rocker_arm_scan.obj", "loop");
  EXPECT_EQ(report["outputs"][0]["quads"], 0);
  EXPECT_EQ(report["outputs"][0]["triangles"], 16 * report["input"]["faces"].get<std::int64_t>());
  EXPECT_THAT(read("s_LOD0.glb"), HasSubstr("\"scheme\":\"loop\""));
  EXPECT_THAT(
      run("fit " PLANISH_SCENES "/icosphere.obj --scheme loop -o i.glb --levels 2 --dry-run").out,
      HasSubstr("81,920 triangles)"));
}

TEST_F(SchemeFlag, RunsOnVulkanAsOnTheCpu) {
  if (!has_vulkan()) GTEST_SKIP() << "no Vulkan device";
  write("plate.obj", bumpy_plate_obj(9));
  for (const std::string scheme : {"catmull-clark", "loop"}) {
    const std::string input = scheme == "loop" ? PLANISH_SCENES "/icosphere.obj" : "plate.obj";
    const json on_cpu = expect_fit_and_verify(input, scheme, " --device cpu");
    const json on_vulkan = expect_fit_and_verify(input, scheme, " --device vulkan");
    EXPECT_EQ(on_cpu["solve"]["iterations"], on_vulkan["solve"]["iterations"]);
    EXPECT_NE(on_vulkan["device"]["kind"], "cpu");
  }
}

TEST_F(SchemeFlag, CreasesOfEverySharpnessHold) {
  write("tagged.obj", bumpy_plate_obj(6) +
                          "t crease 2/1/0 8 9 3.5\nt crease 2/1/0 9 10 10\n"
                          "t corner 1/1/0 24 2\n");
  for (const char* flags : {"", " --boundary edge-and-corner", " --creases auto:5"})
    expect_fit_and_verify("tagged.obj", "catmull-clark", flags);
}

TEST_F(SchemeFlag, ACubeOutOfTrueHasNoCatmullClarkSurface) {
  std::string obj = cube_obj();
  write("cube.obj", obj.replace(obj.find("v 1 1 1"), 7, "v 1 1 1.3"));
  const json report = report_of("fit cube.obj --scheme catmull-clark -o c.glb --cage cage.obj", 5);
  EXPECT_THAT(said_,
              AllOf(HasSubstr("not converged (singular)"), HasSubstr("take --scheme doo-sabin")));
  EXPECT_THAT(read("c.glb"), HasSubstr("\"converged\":false"));
  expect_values(
      report, {{"/exit_code", 5}, {"/solve/converged", false}, {"/solve/stop_reason", "singular"}});
  run("verify cage.obj cube.obj", 5);
}

}  // namespace
}  // namespace planish::test
