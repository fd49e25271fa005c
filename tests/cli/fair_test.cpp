#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <sstream>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

// A unit sphere whose triangles are long and thin in places: rings at random heights, each turned
// at random.
std::string uneven_sphere_obj() {
  constexpr int kRings = 20, kSegments = 20;
  std::mt19937 random(11);
  const auto unit = [&] { return random() * 0x1p-32; };
  std::ostringstream obj;
  obj.precision(17);
  obj << "v 0 0 -1\n";
  for (int ring = 0; ring < kRings; ++ring) {
    const double z = -0.95 + 1.9 * (ring + 0.8 * unit()) / kRings;
    for (int segment = 0; segment < kSegments; ++segment) {
      const double angle = 2 * M_PI * (segment + 0.9 * unit()) / kSegments;
      const double radius = std::sqrt(1 - z * z);
      obj << "v " << radius * std::cos(angle) << ' ' << radius * std::sin(angle) << ' ' << z
          << '\n';
    }
  }
  obj << "v 0 0 1\n";
  const auto at = [](int ring, int segment) {
    return std::to_string(2 + ring * kSegments + segment % kSegments);
  };
  for (int s = 0; s < kSegments; ++s) {
    obj << "f 1 " << at(0, s + 1) << ' ' << at(0, s) << '\n';
    for (int r = 0; r + 1 < kRings; ++r) {
      obj << "f " << at(r, s) << ' ' << at(r, s + 1) << ' ' << at(r + 1, s + 1) << '\n';
      obj << "f " << at(r, s) << ' ' << at(r + 1, s + 1) << ' ' << at(r + 1, s) << '\n';
    }
    obj << "f " << at(kRings - 1, s) << ' ' << at(kRings - 1, s + 1) << ' '
        << 2 + kRings * kSegments << '\n';
  }
  return obj.str();
}

class Fair : public FolderTest {
 protected:
  // The report of a fit of `input`.
  nlohmann::json fit(const std::string& input, std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", input, "--report", path("r.json"), "-f"});
    const ProcessResult result = run_planish(flags);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    messages_ = result.err;
    return read_json("r.json");
  }

  std::string sphere_ = write("sphere.obj", uneven_sphere_obj());
  std::string plate_ = write("plate.obj", bumpy_plate_obj(6));
  std::string messages_;
};

using testing::HasSubstr;
using testing::Not;

TEST_F(Fair, UnfoldsWhatTheProgressiveMethodFolds) {
  const nlohmann::json progressive =
      fit(sphere_, {"-o", path("p.glb"), "--interpolation", "progressive"});
  EXPECT_EQ(progressive["solve"]["method"], "progressive");
  EXPECT_GT(progressive["surface"]["folded_area"], 1e-4);
  EXPECT_THAT(messages_, HasSubstr("--interpolation fair is made for such meshes"));
  const nlohmann::json fair = fit(sphere_, {"-o", path("f.glb"), "--interpolation", "fair"});
  EXPECT_EQ(fair["solve"]["method"], "fair");
  EXPECT_EQ(fair["surface"]["folded_area"], 0.0);
  EXPECT_THAT(messages_, Not(HasSubstr("folded (")));
  for (const char* key : {"rms_normal_deviation", "max_normal_deviation", "bending"}) {
    EXPECT_LT(fair["surface"][key], progressive["surface"][key]) << key;
  }
  // Float32 of the file is all that is lost.
  EXPECT_LT(fair["outputs"][0]["as_written_error"], 1e-7);
}

// A strip of three squares, the last turned back under the second.
TEST_F(Fair, FoldsOfTheInputAreToldFromOthers) {
  const std::string strip =
      write("strip.obj",
            "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 1.1 0 -0.3\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 1.1 1 -0.3\n"
            "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\n");
  const nlohmann::json report = fit(strip, {"-o", path("p.ply"), "--interpolation", "progressive"});
  EXPECT_EQ(report["input"]["folded_edges"]["count"], 1);
  EXPECT_NEAR(report["input"]["folded_edges"]["area"], 0.66, 0.01);
  EXPECT_GT(report["surface"]["folded_area"], 0.01);
  EXPECT_EQ(report["surface"]["folded_area_elsewhere"], 0.0);
  EXPECT_THAT(messages_, HasSubstr("1 edge of the input turn"));
  EXPECT_THAT(messages_, HasSubstr(", 0 % where the input is not; first at face 1 near ("));
  EXPECT_EQ(report["warnings"][0]["first"], 1);
  const nlohmann::json inspected =
      nlohmann::json::parse(run_planish({"inspect", strip, "--json"}).out);
  EXPECT_EQ(inspected["folded_edges"]["count"], 1);
  EXPECT_EQ(inspected["folded_edges"]["first_face"], 1);
  EXPECT_THAT(run_planish({"inspect", strip}).out, HasSubstr("folded edges      1 turn by more"));
}

// Against the surface that was scanned: facets differ from every smooth surface.
TEST_F(Fair, UnfoldsASimplifiedScan) {
  const std::string scan = std::string(PLANISH_SCENES) + "/rocker_arm_scan.obj";
  fit(std::string(PLANISH_SCENES) + "/rocker_arm.obj",
      {"-o", path("arm.obj"), "--interpolation", "progressive"});
  std::vector<std::string> flags{
      "-o", path("s.glb"), "--source", path("arm.obj"), "--interpolation", "progressive"};
  const nlohmann::json progressive = fit(scan, flags);
  flags.back() = "fair";
  const nlohmann::json fair = fit(scan, flags);
  EXPECT_GT(progressive["surface"]["folded_area"], 5e-4);
  EXPECT_EQ(fair["surface"]["folded_area"], 0.0);
  EXPECT_EQ(fair["solve"]["fair"]["flagged_edges"], 0);
  EXPECT_EQ(fair["solve"]["fair"]["flagged_faces"], 0);
  EXPECT_LT(fair["surface"]["rms_normal_deviation"].get<double>(),
            0.5 * progressive["surface"]["rms_normal_deviation"].get<double>());
}

TEST_F(Fair, CutsConcaveFaces) {
  const std::string bracket = std::string(PLANISH_SCENES) + "/l_bracket.obj";
  const std::vector<std::string> outputs{"-o", path("s.glb"), "--cage", path("c.obj")};
  std::vector<std::string> flags = outputs;
  flags.insert(flags.end(), {"--interpolation", "progressive"});
  EXPECT_GT(fit(bracket, flags)["surface"]["folded_area"], 0.01);
  flags.back() = "fair";
  const nlohmann::json fair = fit(bracket, flags);
  EXPECT_EQ(fair["surface"]["folded_area"], 0.0);
  EXPECT_EQ(fair["input"]["changed_faces"], (nlohmann::json{0, 1}));
  EXPECT_THAT(messages_,
              HasSubstr("faces with corners that turn inward or lie unevenly, cut in parts"));
  EXPECT_EQ(run_planish({"verify", path("c.obj"), bracket}).exit_code, 0);
  // Left as they are, they fold and are named.
  flags.insert(flags.end(), {"--repair", "none"});
  EXPECT_GT(fit(bracket, flags)["surface"]["folded_area"], 0.01);
  EXPECT_THAT(messages_, HasSubstr("beside which the fair surface may fold: 2; "));
  EXPECT_THAT(messages_, HasSubstr("--creases auto may help"));
  EXPECT_EQ(run_planish({"verify", path("c.obj"), bracket}).exit_code, 0);
  // What was asked for already is not the advice.
  std::vector<std::string> with_creases = flags;
  with_creases.insert(with_creases.end(), {"--creases", "auto"});
  EXPECT_GT(fit(bracket, with_creases)["surface"]["folded_area"], 0.01);
  EXPECT_THAT(messages_, HasSubstr("found creases do not help there"));
  EXPECT_THAT(messages_, Not(HasSubstr("--creases auto may help")));
  // What nothing can cut is not promised to be.
  fit(write("bow.obj", "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 2 0\nf 1 2 3 4\n"),
      {"-o", path("s.glb"), "--interpolation", "fair"});
  EXPECT_THAT(messages_, HasSubstr("may fold: 1; they cross themselves: cut them in triangles"));
}

// What measurement has tried and left is not the advice either.
TEST_F(Fair, DoesNotAdviseWhatWasTried) {
  const std::string input = write("bow.obj", "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 2 0\nf 1 2 3 4\n");
  EXPECT_GT(fit(input, {"-o", path("s.glb")})["surface"]["folded_area"], 0.01);
  EXPECT_THAT(messages_, HasSubstr("found creases do not help there"));
  EXPECT_THAT(messages_, Not(HasSubstr("--creases auto may help")));
}

TEST_F(Fair, TheReportSaysWhatWasDone) {
  const nlohmann::json solve = fit(
      sphere_, {"--interpolation", "fair", "--polish", "3", "-v", "-o", path("f.ply")})["solve"];
  EXPECT_EQ(solve["solver"], nullptr);
  EXPECT_EQ(solve["spectral_bound"], nullptr);
  EXPECT_EQ(solve["iterations"], 0);
  EXPECT_EQ(solve["history"].size(), 0u);
  EXPECT_LT(solve["error"]["max"], 1e-14);
  EXPECT_EQ(solve["fair"]["polish"], 3);
  EXPECT_EQ(solve["fair"]["flagged_edges"], 0);
  EXPECT_GE(solve["fair"]["shrunk_vertices"], 0);
  EXPECT_THAT(messages_, HasSubstr("fair (3 polish steps"));
  EXPECT_GE(solve["fair"]["cured_vertices"], 0);
  EXPECT_EQ(fit(plate_, {"-o", path("p.ply"), "--interpolation", "progressive"})["solve"]["fair"],
            nullptr);
}

TEST_F(Fair, PolishChangesTheSurface) {
  const nlohmann::json rough =
      fit(sphere_, {"--interpolation", "fair", "--polish", "0", "-o", path("a.ply")});
  const nlohmann::json polished = fit(sphere_, {"--interpolation", "fair", "-o", path("b.ply")});
  EXPECT_EQ(polished["solve"]["fair"]["polish"], 8);
  EXPECT_LT(polished["surface"]["bending"], rough["surface"]["bending"]);
}

TEST_F(Fair, IsASettingOfScenesAndOverridesThePreset) {
  write("s.json", R"({"version":1,"jobs":[{"input":"sphere.obj","source":"sphere.obj",
    "solve":{"preset":"paper","interpolation":"fair","polish":2},
    "outputs":[{"path":"s.glb"}],"report":"r.json"}]})");
  ASSERT_EQ(run_planish({"run", path("s.json")}).exit_code, 0);
  const nlohmann::json report = read_json("r.json");
  EXPECT_EQ(report["solve"]["method"], "fair");
  EXPECT_EQ(report["solve"]["weights"], "averaged");
  EXPECT_EQ(report["solve"]["fair"]["polish"], 2);
  EXPECT_EQ(report["surface"]["reference"], sphere_);
}

TEST_F(Fair, RunsOnVulkanAsOnTheCpu) {
  const std::string creased =
      write("creased.obj", torus_obj(8) + "t crease 2/1/0 0 1 10\nt crease 2/1/0 1 2 10\n");
  if (run_planish({"fit", plate_, "-o", path("t.glb"), "--device", "vulkan"}).exit_code == 6) {
    GTEST_SKIP() << "no Vulkan device";
  }
  for (const std::string& input : {sphere_, plate_, creased}) {
    SCOPED_TRACE(input);
    const std::vector<std::string> flags = {"-o",     path("f.glb"), "--interpolation", "fair",
                                            "--cage", path("c.obj"), "--device"};
    const auto on = [&](const char* device) {
      std::vector<std::string> all = flags;
      all.push_back(device);
      return fit(input, all);
    };
    const nlohmann::json expected = on("cpu"), report = on("vulkan");
    EXPECT_NE(report["device"]["kind"], "cpu");
    EXPECT_EQ(report["solve"]["method"], "fair");
    EXPECT_TRUE(report["solve"]["converged"]);
    EXPECT_LT(report["solve"]["error"]["max"], 9e-8);  // all in single precision
    EXPECT_GT(report["solve"]["error"]["max"], 0);
    EXPECT_LT(report["outputs"][0]["as_written_error"], 1e-6);
    EXPECT_EQ(report["surface"]["folded_area"], 0.0);
    EXPECT_EQ(report["solve"]["fair"]["flagged_edges"], expected["solve"]["fair"]["flagged_edges"]);
    EXPECT_NEAR(report["surface"]["rms_normal_deviation"],
                expected["surface"]["rms_normal_deviation"], 0.01);
    // The cage in the folder is that of the device.
    const ProcessResult verified = run_planish({"verify", path("c.obj"), input, "--json"});
    EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
    EXPECT_EQ(nlohmann::json::parse(verified.out)["interpolation"], "fair");
  }
}

TEST_F(Fair, CagesOfEveryFormatAreConfirmed) {
  const std::string creased =
      write("creased.obj", torus_obj(8) + "t crease 2/1/0 0 1 10\nt crease 2/1/0 1 2 10\n");
  const std::string mapped = PLANISH_SCENES "/mapped_cube.obj";
  const std::string holed = PLANISH_SCENES "/cube_with_windows.obj";
  for (const std::string& input : {sphere_, plate_, creased, mapped, holed}) {
    for (const std::string name : {"c.obj", "c.ply", "c.off"}) {
      const nlohmann::json report = fit(input, {"--interpolation", "fair", "--cage", path(name)});
      const ProcessResult result = run_planish({"verify", path(name), input, "--json"});
      EXPECT_EQ(result.exit_code, 0) << input << ' ' << name << result.err;
      const nlohmann::json verified = nlohmann::json::parse(result.out);
      EXPECT_EQ(verified["interpolation"], "fair");
      EXPECT_LT(verified["error"]["max"], 1e-14);
      EXPECT_EQ(verified["error"]["max"], report["outputs"][0]["as_written_error"]);
    }
  }
}

TEST_F(Fair, TheCageKeepsItsPolygons) {
  const nlohmann::json report = fit(sphere_, {"--interpolation", "fair", "--cage", path("c.obj")});
  // 402 vertices, 800 triangles, 1200 edges; each edge a quad, two control points a side.
  EXPECT_EQ(report["outputs"][0]["vertices"], 2400);
  EXPECT_THAT(read("c.obj"), HasSubstr("# planish interpolation=fair\n"));
  const ProcessResult inspected = run_planish({"inspect", path("c.obj"), "--json"});
  ASSERT_EQ(inspected.exit_code, 0);
  const nlohmann::json sizes = nlohmann::json::parse(inspected.out)["face_sizes"];
  EXPECT_EQ(sizes["20"], 2);  // around the poles
  EXPECT_GE(sizes["3"], 800);
  EXPECT_GE(sizes["4"], 1200);
}

TEST_F(Fair, AMovedOrForeignCageIsRejected) {
  (void)fit(sphere_, {"--interpolation", "fair", "--cage", path("c.obj")});
  std::string cage = read("c.obj");
  const std::size_t first = cage.find("\nv ") + 3;
  cage.replace(first, cage.find(' ', first) - first, "0.5");
  write("moved.obj", cage);
  EXPECT_EQ(run_planish({"verify", path("moved.obj"), sphere_}).exit_code, 5);
  const ProcessResult foreign = run_planish({"verify", path("c.obj"), plate_});
  EXPECT_EQ(foreign.exit_code, 4);
  EXPECT_THAT(foreign.err, HasSubstr("is no cage of"));
  // Taken for a cage on the mesh itself it has too many faces.
  EXPECT_EQ(
      run_planish({"verify", path("c.obj"), sphere_, "--interpolation", "progressive"}).exit_code,
      4);
}

TEST_F(Fair, AToleranceBelowRoundingIsNotReached) {
  const ProcessResult result = run_planish(
      {"fit", plate_, "--interpolation", "fair", "-o", path("f.ply"), "--tolerance", "1e-30"});
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.err, HasSubstr("raise --tolerance"));
}

TEST_F(Fair, TheSourceIsWhatTheSurfaceIsComparedWith) {
  const nlohmann::json itself = fit(sphere_, {"-o", path("p.ply"), "--source", sphere_});
  EXPECT_EQ(itself["surface"]["reference"], sphere_);
  EXPECT_GT(itself["surface"]["max_source_distance"], 0.0);
  EXPECT_LT(itself["surface"]["rms_source_distance"], itself["surface"]["max_source_distance"]);
  // The surface passes through the source's vertices, and is compared with them without triangles.
  EXPECT_LT(itself["surface"]["max_distance_from_source"], 1e-12);
  // A torus is no sphere.
  const std::string torus = write("torus.obj", torus_obj(12));
  const nlohmann::json other = fit(sphere_, {"-o", path("p.ply"), "--source", torus});
  EXPECT_GT(other["surface"]["rms_source_distance"],
            10 * itself["surface"]["rms_source_distance"].get<double>());
  EXPECT_GT(other["surface"]["rms_distance_from_source"], 0.01);
  EXPECT_GT(other["surface"]["rms_normal_deviation"], itself["surface"]["rms_normal_deviation"]);
}

TEST_F(Fair, ASourceHasToBeAMesh) {
  const std::string empty = write("empty.obj", "v 0 0 0\n");
  const std::vector<std::string> common{"fit", plate_, "-o", path("p.ply"), "--source"};
  const auto with = [&](const std::string& source) {
    std::vector<std::string> arguments = common;
    arguments.push_back(source);
    return run_planish(arguments);
  };
  EXPECT_EQ(with(empty).exit_code, 4);
  EXPECT_THAT(with(empty).err, HasSubstr("empty.obj: a source has to be a mesh"));
  EXPECT_EQ(with(path("missing.obj")).exit_code, 3);
  EXPECT_EQ(with(path("p.ply")).exit_code, 2);  // no input is overwritten
}

// What is chosen where the method, creases and quads are left open.

TEST_F(Fair, AutoTakesWhatFoldsLessAndSaysWhy) {
  const nlohmann::json taken =
      fit(sphere_, {"-o", path("a.ply"), "--refine", "off", "--creases", "use", "--quads", "off"});
  EXPECT_EQ(taken["solve"]["method"], "fair");
  EXPECT_THAT(messages_, HasSubstr("surface     fair: progressive folds"));
  const nlohmann::json& choice = taken["solve"]["choice"];
  EXPECT_THAT(choice["reason"].get<std::string>(), HasSubstr("fair: progressive folds"));
  ASSERT_EQ(choice["candidates"].size(), 2u);
  const nlohmann::json &fair = choice["candidates"][0], &progressive = choice["candidates"][1];
  EXPECT_EQ(progressive["method"], "progressive");
  EXPECT_EQ(progressive["taken"], false);
  EXPECT_GT(progressive["folded_area_elsewhere"], 1e-4);
  EXPECT_EQ(fair["taken"], true);
  EXPECT_LT(fair["folded_area_elsewhere"], 1e-5);
  EXPECT_LT(fair["cost"], progressive["cost"]);
  // The surface is that of the method asked for by name.
  const nlohmann::json asked =
      fit(sphere_, {"-o", path("f.ply"), "--interpolation", "fair", "--quads", "off"});
  EXPECT_EQ(asked["solve"]["choice"], nullptr);
  EXPECT_EQ(taken["outputs"][0]["sha256"], asked["outputs"][0]["sha256"]);
}

// What repair and the cutting of concave faces change of the mesh is told as of a fair fit.
TEST_F(Fair, AutoTakesTheMeshThatItsSurfaceIsOf) {
  const std::string bracket = std::string(PLANISH_SCENES) + "/l_bracket.obj";
  const nlohmann::json taken = fit(bracket, {"-o", path("a.ply"), "--creases", "use"});
  const nlohmann::json asked = fit(bracket, {"-o", path("f.ply"), "--interpolation", "fair"});
  EXPECT_EQ(taken["solve"]["method"], "fair");
  EXPECT_EQ(taken["input"], asked["input"]);
  EXPECT_EQ(taken["warnings"], asked["warnings"]);
  EXPECT_EQ(taken["outputs"][0]["sha256"], asked["outputs"][0]["sha256"]);
}

TEST_F(Fair, AutoTakesCreasesThatAreClear) {
  const std::string bracket = std::string(PLANISH_SCENES) + "/l_bracket.obj";
  const nlohmann::json taken = fit(bracket, {"-o", path("a.ply")});
  EXPECT_THAT(messages_, HasSubstr("18 edges kept sharp"));
  EXPECT_EQ(taken["solve"]["creases"], "auto");
  EXPECT_EQ(taken["solve"]["choice"]["candidates"].size(), 1u) << "no fit that nobody needs";
  EXPECT_LT(taken["surface"]["rms_normal_deviation"], 1e-4);
  const nlohmann::json asked =
      fit(bracket, {"-o", path("f.ply"), "--interpolation", "fair", "--creases", "auto"});
  EXPECT_EQ(taken["outputs"][0]["sha256"], asked["outputs"][0]["sha256"]);
  EXPECT_EQ(fit(bracket, {"-o", path("s.ply"), "--creases", "use"})["input"]["sharp_edges"], 0);
  const nlohmann::json named = fit(bracket, {"-o", path("p.ply"), "--interpolation", "fair"});
  EXPECT_EQ(named["input"]["sharp_edges"], 0) << "a named method leaves nothing to choose";
}

// Quads of a torus, cut in two.
TEST_F(Fair, AutoJoinsTrianglesThatAreHalvesOfQuads) {
  std::string obj;
  const auto at = [](int i, int j) { return std::to_string(1 + i % 24 * 12 + j % 12); };
  for (int i = 0; i < 24; ++i)
    for (int j = 0; j < 12; ++j) {
      const double ring = 1 + 0.4 * std::cos(j * M_PI / 6);
      obj += "v " + std::to_string(ring * std::cos(i * M_PI / 12)) + " " +
             std::to_string(ring * std::sin(i * M_PI / 12)) + " " +
             std::to_string(0.4 * std::sin(j * M_PI / 6)) + "\nf " + at(i, j) + " " + at(i + 1, j) +
             " " + at(i + 1, j + 1) + "\nf " + at(i, j) + " " + at(i + 1, j + 1) + " " +
             at(i, j + 1) + "\n";
    }
  const std::string torus = write("torus.obj", obj);
  const nlohmann::json taken = fit(torus, {"-o", path("a.ply")});
  EXPECT_EQ(taken["solve"]["quads"]["joined"], 288);
  EXPECT_EQ(taken["outputs"][0]["quads"], 288 * 16);
  for (const nlohmann::json& candidate : taken["solve"]["choice"]["candidates"])
    EXPECT_EQ(candidate["faces"], "quads") << "that of triangles was not made";
  EXPECT_THAT(messages_, HasSubstr("whose halves they are (--quads off leaves them)"));
  EXPECT_THAT(messages_, HasSubstr("288 vertices, 576 faces, 288 with triangles joined (closed"));
  const nlohmann::json asked = fit(torus, {"-o", path("o.ply"), "--quads", "on"});
  EXPECT_EQ(asked["outputs"][0]["sha256"], taken["outputs"][0]["sha256"]);
  EXPECT_EQ(asked["solve"]["choice"]["faces_reason"], nullptr);
  EXPECT_THAT(messages_, Not(HasSubstr("--quads off")));
  const nlohmann::json left =
      fit(torus, {"-o", path("l.ply"), "--quads", "off", "--refine", "off"});
  EXPECT_EQ(left["outputs"][0]["quads"], 2 * 288 * 12);

  // A cage has the mesh's faces; of quads that were asked for it says so, and verify finds them.
  for (const char* method : {"progressive", "fair"}) {
    for (const char* quads : {"auto", "on"}) {
      fit(torus, {"--cage", path("c.obj"), "--interpolation", method, "--quads", quads});
      const bool is_joined = std::string(quads) == "on";
      EXPECT_THAT(read("c.obj"),
                  HasSubstr(is_joined ? "planish quads=on\n" : "planish quads=off\n"));
      EXPECT_EQ(run_planish({"verify", path("c.obj"), torus}).exit_code, 0) << method;
      EXPECT_EQ(run_planish({"verify", path("c.obj"), torus, "--quads", is_joined ? "off" : "on"})
                    .exit_code,
                4);
    }
  }
  EXPECT_THAT(
      run_planish({"fit", torus, "-o", path("x.ply"), "--scheme", "loop", "--quads", "on"}).err,
      HasSubstr("--quads: loop surfaces are of triangles; take off"));
}

// A part's flat faces do not say what its triangles are: both surfaces are made.
TEST_F(Fair, AutoMeasuresQuadsAgainstTrianglesOfParts) {
  const std::string box =
      write("box.obj",
            "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
            "f 1 4 3\nf 1 3 2\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\n"
            "f 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n");
  const nlohmann::json choice = fit(box, {"-o", path("b.ply")})["solve"]["choice"];
  ASSERT_EQ(choice["candidates"].size(), 2u);
  for (const nlohmann::json& candidate : choice["candidates"])
    EXPECT_LT(candidate["bending"], 1e-6);
  EXPECT_EQ(choice["faces_reason"],
            "triangles joined to quads: all is flat (--quads off leaves them)");
}

// Its own surface is progressive: of the mesh's faces, and sharp where the other is.
TEST_F(Fair, ACageLeavesTheSurfaceBesideItAlone) {
  for (const std::string& input : {sphere_, write("cube.obj", cube_obj())}) {
    const nlohmann::json alone = fit(input, {"-o", path("a.ply")});
    const nlohmann::json both = fit(input, {"-o", path("p.ply"), "--cage", path("c.obj")});
    EXPECT_EQ(alone["solve"]["method"], "fair") << input;
    EXPECT_EQ(both["outputs"][0]["sha256"], alone["outputs"][0]["sha256"]) << input;
    EXPECT_EQ(both["solve"], alone["solve"]) << input;
    EXPECT_THAT(read("c.obj"), HasSubstr("planish interpolation=progressive\n"));
    EXPECT_EQ(run_planish({"verify", path("c.obj"), input}).exit_code, 0) << input;
    // And the surface beside does not change the cage.
    const nlohmann::json cage = fit(input, {"--cage", path("d.obj")});
    EXPECT_EQ(cage["outputs"][0]["sha256"], both["outputs"][1]["sha256"]) << input;
    EXPECT_EQ(cage["solve"]["method"], "progressive") << input;
    EXPECT_THAT(messages_, HasSubstr("surface     progressive: the control cage"));
  }
  EXPECT_THAT(read("c.obj"), HasSubstr("planish sharp_edges=0-1 "));
}

// Whatever is sharp stands in the header: of a mesh that another version would find others on.
TEST_F(Fair, ACageSaysWhichEdgesAreSharp) {
  const std::string cube = write("cube.obj", cube_obj());
  for (const char* name : {"c.ply", "c.off"}) {
    fit(cube, {"--cage", path(name)});
    std::string cage = read(name);
    EXPECT_EQ(run_planish({"verify", path(name), cube}).exit_code, 0) << name;
    EXPECT_EQ(run_planish({"verify", path(name), cube, "--creases", "auto"}).exit_code, 0);
    EXPECT_EQ(run_planish({"verify", path(name), cube, "--creases", "use"}).exit_code, 5) << name;
    const std::size_t first = cage.find("0-1 ");
    ASSERT_NE(first, std::string::npos) << name;
    cage.erase(first, 4);
    EXPECT_EQ(
        run_planish({"verify", write(std::string("less") + (name + 1), cage), cube}).exit_code, 5)
        << name;
  }
}

TEST_F(Fair, AutoSparesTheSecondFitOfSmoothMeshes) {
  const std::string plate = write("fine.obj", bumpy_plate_obj(120));
  const nlohmann::json solve = fit(plate, {"-o", path("p.ply")})["solve"];
  EXPECT_EQ(solve["method"], "progressive");
  EXPECT_EQ(solve["choice"]["candidates"].size(), 1u);
  EXPECT_THAT(messages_, HasSubstr("surface     progressive: it does not fold"));
  // At level 0 what was measured for the choice is what the surface is reported with.
  const nlohmann::json chosen = fit(plate, {"-o", path("p.ply"), "--levels", "0"});
  const nlohmann::json asked = fit(plate, {"-o", path("p.ply"), "--levels", "0", "--interpolation",
                                           "progressive", "--creases", "auto:180"});
  EXPECT_EQ(chosen["surface"], asked["surface"]);
}

}  // namespace
}  // namespace planish::test
