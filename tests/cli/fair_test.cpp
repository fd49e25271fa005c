#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <random>
#include <sstream>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

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

constexpr const char* kBracket = PLANISH_SCENES "/l_bracket.obj";

class Fair : public FolderTest {
 protected:
  // The report of a fit of `input`.
  json fit(const std::string& input, const std::string& flags) {
    return report_of("fit " + input + " " + flags);
  }

  std::string sphere_ = write("sphere.obj", uneven_sphere_obj());
  std::string plate_ = write("plate.obj", bumpy_plate_obj(6));
  std::string creased_ =
      write("creased.obj", torus_obj(8) + "t crease 2/1/0 0 1 10\nt crease 2/1/0 1 2 10\n");
};

TEST_F(Fair, UnfoldsWhatTheProgressiveMethodFolds) {
  const json progressive = fit("sphere.obj", "-o p.glb --interpolation progressive");
  EXPECT_EQ(progressive["solve"]["method"], "progressive");
  EXPECT_GT(progressive["surface"]["folded_area"], 1e-4);
  EXPECT_THAT(said_, HasSubstr("--interpolation fair is made for such meshes"));
  const json fair = fit("sphere.obj", "-o f.glb --interpolation fair");
  expect_values(fair, {{"/solve/method", "fair"}, {"/surface/folded_area", 0.0}});
  EXPECT_THAT(said_, Not(HasSubstr("folded (")));
  for (const char* key : {"rms_normal_deviation", "max_normal_deviation", "bending"})
    EXPECT_LT(fair["surface"][key], progressive["surface"][key]) << key;
  // Float32 of the file is all that is lost.
  EXPECT_LT(fair["outputs"][0]["as_written_error"], 1e-7);
}

// A strip of three squares, the last turned back under the second.
TEST_F(Fair, FoldsOfTheInputAreToldFromOthers) {
  write("strip.obj",
        "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 1.1 0 -0.3\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 1.1 1 -0.3\n"
        "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\n");
  const json report = fit("strip.obj", "-o p.ply --interpolation progressive");
  EXPECT_EQ(report["input"]["folded_edges"]["count"], 1);
  EXPECT_NEAR(report["input"]["folded_edges"]["area"], 0.66, 0.01);
  EXPECT_GT(report["surface"]["folded_area"], 0.01);
  EXPECT_EQ(report["surface"]["folded_area_elsewhere"], 0.0);
  EXPECT_THAT(said_, HasSubstr("1 edge of the input turn"));
  EXPECT_THAT(said_, HasSubstr(", 0 % where the input is not; first at face 1 near ("));
  EXPECT_EQ(report["warnings"][0]["first"], 1);
  const json edges = printed("inspect strip.obj --json")["folded_edges"];
  expect_values(edges, {{"/count", 1}, {"/first_face", 1}});
  EXPECT_THAT(run("inspect strip.obj").out, HasSubstr("folded edges      1 turn by more"));
}

// Against the surface that was scanned: facets differ from every smooth surface.
TEST_F(Fair, UnfoldsASimplifiedScan) {
  const std::string scan = PLANISH_SCENES "/rocker_arm_scan.obj";
  fit(PLANISH_SCENES "/rocker_arm.obj", "-o arm.obj --interpolation progressive");
  const json progressive =
      fit(scan, "-o s.glb --source arm.obj --interpolation progressive")["surface"];
  const json report = fit(scan, "-o s.glb --source arm.obj --interpolation fair");
  EXPECT_GT(progressive["folded_area"], 5e-4);
  expect_values(report, {{"/surface/folded_area", 0.0},
                         {"/solve/fair/flagged_edges", 0},
                         {"/solve/fair/flagged_faces", 0}});
  EXPECT_LT(report["surface"]["rms_normal_deviation"].get<double>(),
            0.5 * progressive["rms_normal_deviation"].get<double>());
}

TEST_F(Fair, CutsConcaveFaces) {
  const std::string flags = "-o s.glb --cage c.obj --interpolation ";
  const auto folded_area = [&](const std::string& more) {
    return fit(kBracket, flags + more)["surface"]["folded_area"].get<double>();
  };
  EXPECT_GT(folded_area("progressive"), 0.01);
  const json fair = fit(kBracket, flags + "fair");
  EXPECT_EQ(fair["surface"]["folded_area"], 0.0);
  EXPECT_EQ(fair["input"]["changed_faces"], (json{0, 1}));
  EXPECT_THAT(said_,
              HasSubstr("faces with corners that turn inward or lie unevenly, cut in parts"));
  run(std::string("verify c.obj ") + kBracket);
  // Left as they are, they fold and are named.
  EXPECT_GT(folded_area("fair --repair none"), 0.01);
  EXPECT_THAT(said_, HasSubstr("beside which the fair surface may fold: 2; "));
  EXPECT_THAT(said_, HasSubstr("--creases auto may help"));
  run(std::string("verify c.obj ") + kBracket);
  // What was asked for already is not the advice.
  EXPECT_GT(folded_area("fair --repair none --creases auto"), 0.01);
  EXPECT_THAT(said_, HasSubstr("found creases do not help there"));
  EXPECT_THAT(said_, Not(HasSubstr("--creases auto may help")));
  // What nothing can cut is not promised to be.
  write("bow.obj", "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 2 0\nf 1 2 3 4\n");
  fit("bow.obj", "-o s.glb --interpolation fair");
  EXPECT_THAT(said_, HasSubstr("may fold: 1; they cross themselves: cut them in triangles"));
  // What measurement has tried and left is not the advice either.
  EXPECT_GT(fit("bow.obj", "-o s.glb")["surface"]["folded_area"], 0.01);
  EXPECT_THAT(said_, HasSubstr("found creases do not help there"));
  EXPECT_THAT(said_, Not(HasSubstr("--creases auto may help")));
}

TEST_F(Fair, TheReportSaysWhatWasDone) {
  const json solve = fit("sphere.obj", "--interpolation fair --polish 3 -v -o f.ply")["solve"];
  expect_values(solve, {{"/solver", nullptr}, {"/spectral_bound", nullptr}, {"/iterations", 0}});
  EXPECT_EQ(solve["history"].size(), 0u);
  EXPECT_LT(solve["error"]["max"], 1e-14);
  expect_values(solve, {{"/fair/polish", 3}, {"/fair/flagged_edges", 0}});
  EXPECT_GE(solve["fair"]["shrunk_vertices"], 0);
  EXPECT_THAT(said_, HasSubstr("fair (3 polish steps"));
  EXPECT_GE(solve["fair"]["cured_vertices"], 0);
  EXPECT_EQ(fit("plate.obj", "-o p.ply --interpolation progressive")["solve"]["fair"], nullptr);
}

TEST_F(Fair, PolishChangesTheSurface) {
  const json rough = fit("sphere.obj", "--interpolation fair --polish 0 -o a.ply");
  const json polished = fit("sphere.obj", "--interpolation fair -o b.ply");
  EXPECT_EQ(polished["solve"]["fair"]["polish"], 8);
  EXPECT_LT(polished["surface"]["bending"], rough["surface"]["bending"]);
}

TEST_F(Fair, IsASettingOfScenesAndOverridesThePreset) {
  write("s.json", R"({"version":1,"jobs":[{"input":"sphere.obj","source":"sphere.obj",
    "solve":{"preset":"paper","interpolation":"fair","polish":2},
    "outputs":[{"path":"s.glb"}],"report":"r.json"}]})");
  run("run s.json");
  const json report = read_json("r.json");
  expect_values(report, {{"/solve/method", "fair"},
                         {"/solve/weights", "averaged"},
                         {"/solve/fair/polish", 2},
                         {"/surface/reference", "sphere.obj"}});
}

TEST_F(Fair, RunsOnVulkanAsOnTheCpu) {
  if (!has_vulkan()) GTEST_SKIP() << "no Vulkan device";
  for (const std::string input : {"sphere.obj", "plate.obj", "creased.obj"}) {
    SCOPED_TRACE(input);
    const std::string flags = "-o f.glb --interpolation fair --cage c.obj --device ";
    const json expected = fit(input, flags + "cpu"), report = fit(input, flags + "vulkan");
    EXPECT_NE(report["device"]["kind"], "cpu");
    expect_values(report, {{"/solve/method", "fair"}, {"/solve/converged", true}});
    EXPECT_LT(report["solve"]["error"]["max"], 9e-8);  // all in single precision
    EXPECT_GT(report["solve"]["error"]["max"], 0);
    EXPECT_LT(report["outputs"][0]["as_written_error"], 1e-6);
    EXPECT_EQ(report["surface"]["folded_area"], 0.0);
    EXPECT_EQ(report["solve"]["fair"]["flagged_edges"], expected["solve"]["fair"]["flagged_edges"]);
    EXPECT_NEAR(report["surface"]["rms_normal_deviation"],
                expected["surface"]["rms_normal_deviation"], 0.01);
    // The cage in the folder is that of the device.
    EXPECT_EQ(printed("verify c.obj " + input + " --json")["interpolation"], "fair");
  }
}

TEST_F(Fair, CagesOfEveryFormatAreConfirmed) {
  for (const std::string input :
       {"sphere.obj", "plate.obj", "creased.obj", PLANISH_SCENES "/mapped_cube.obj",
        PLANISH_SCENES "/cube_with_windows.obj"}) {
    for (const std::string name : {"c.obj", "c.ply", "c.off"}) {
      SCOPED_TRACE(input + " " + name);
      const json report = fit(input, "--interpolation fair --cage " + name);
      const json verified = printed("verify " + name + " " + input + " --json");
      EXPECT_EQ(verified["interpolation"], "fair");
      EXPECT_LT(verified["error"]["max"], 1e-14);
      EXPECT_EQ(verified["error"]["max"], report["outputs"][0]["as_written_error"]);
    }
  }
}

TEST_F(Fair, TheCageKeepsItsPolygons) {
  const json report = fit("sphere.obj", "--interpolation fair --cage c.obj");
  // 402 vertices, 800 triangles, 1200 edges; each edge a quad, two control points a side.
  EXPECT_EQ(report["outputs"][0]["vertices"], 2400);
  EXPECT_THAT(read("c.obj"), HasSubstr("# planish interpolation=fair\n"));
  const json sizes = printed("inspect c.obj --json")["face_sizes"];
  EXPECT_EQ(sizes["20"], 2);  // around the poles
  EXPECT_GE(sizes["3"], 800);
  EXPECT_GE(sizes["4"], 1200);
}

TEST_F(Fair, AMovedOrForeignCageIsRejected) {
  fit("sphere.obj", "--interpolation fair --cage c.obj");
  std::string cage = read("c.obj");
  const std::size_t first = cage.find("\nv ") + 3;
  write("moved.obj", cage.replace(first, cage.find(' ', first) - first, "0.5"));
  run("verify moved.obj sphere.obj", 5);
  run("verify c.obj plate.obj", 4);
  // Taken for a cage on the mesh itself it has too many faces.
  run("verify c.obj sphere.obj --interpolation progressive", 4);
}

TEST_F(Fair, AToleranceBelowRoundingIsNotReached) {
  run("fit plate.obj --interpolation fair -o f.ply --tolerance 1e-30", 5);
  EXPECT_THAT(said_, HasSubstr("raise --tolerance"));
}

TEST_F(Fair, TheSourceIsWhatTheSurfaceIsComparedWith) {
  const json itself = fit("sphere.obj", "-o p.ply --source sphere.obj")["surface"];
  EXPECT_EQ(itself["reference"], "sphere.obj");
  EXPECT_GT(itself["max_source_distance"], 0.0);
  EXPECT_LT(itself["rms_source_distance"], itself["max_source_distance"]);
  // The surface passes through the source's vertices, and is compared with them without triangles.
  EXPECT_LT(itself["max_distance_from_source"], 1e-12);
  // A torus is no sphere.
  write("torus.obj", torus_obj(12));
  const json other = fit("sphere.obj", "-o p.ply --source torus.obj")["surface"];
  EXPECT_GT(other["rms_source_distance"], 10 * itself["rms_source_distance"].get<double>());
  EXPECT_GT(other["rms_distance_from_source"], 0.01);
  EXPECT_GT(other["rms_normal_deviation"], itself["rms_normal_deviation"]);
}

// What is chosen where the method, creases and quads are left open.

TEST_F(Fair, AutoTakesWhatFoldsLessAndSaysWhy) {
  const json taken = fit("sphere.obj", "-o a.ply --refine off --creases use --quads off");
  EXPECT_EQ(taken["solve"]["method"], "fair");
  EXPECT_THAT(said_, HasSubstr("surface     fair: progressive folds"));
  const json& choice = taken["solve"]["choice"];
  EXPECT_THAT(choice["reason"].get<std::string>(), HasSubstr("fair: progressive folds"));
  ASSERT_EQ(choice["candidates"].size(), 2u);
  const json &fair = choice["candidates"][0], &progressive = choice["candidates"][1];
  expect_values(progressive, {{"/method", "progressive"}, {"/taken", false}});
  EXPECT_GT(progressive["folded_area_elsewhere"], 1e-4);
  EXPECT_EQ(fair["taken"], true);
  EXPECT_LT(fair["folded_area_elsewhere"], 1e-5);
  EXPECT_LT(fair["cost"], progressive["cost"]);
  // The surface is that of the method asked for by name.
  const json asked = fit("sphere.obj", "-o f.ply --interpolation fair --quads off");
  EXPECT_EQ(asked["solve"]["choice"], nullptr);
  EXPECT_EQ(taken["outputs"][0]["sha256"], asked["outputs"][0]["sha256"]);
}

// What repair and the cutting of concave faces change of the mesh is told as of a fair fit.
TEST_F(Fair, AutoTakesTheMeshThatItsSurfaceIsOf) {
  const json taken = fit(kBracket, "-o a.ply --creases use");
  const json asked = fit(kBracket, "-o f.ply --interpolation fair");
  EXPECT_EQ(taken["solve"]["method"], "fair");
  EXPECT_EQ(taken["input"], asked["input"]);
  EXPECT_EQ(taken["input"]["sharp_edges"], 0);
  EXPECT_EQ(taken["warnings"], asked["warnings"]);
  EXPECT_EQ(taken["outputs"][0]["sha256"], asked["outputs"][0]["sha256"]);
}

TEST_F(Fair, AutoTakesCreasesThatAreClear) {
  const json taken = fit(kBracket, "-o a.ply");
  EXPECT_THAT(said_, HasSubstr("18 edges kept sharp"));
  EXPECT_EQ(taken["solve"]["creases"], "auto");
  EXPECT_EQ(taken["solve"]["choice"]["candidates"].size(), 1u) << "no fit that nobody needs";
  EXPECT_LT(taken["surface"]["rms_normal_deviation"], 1e-4);
  const json asked = fit(kBracket, "-o f.ply --interpolation fair --creases auto");
  EXPECT_EQ(taken["outputs"][0]["sha256"], asked["outputs"][0]["sha256"]);
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
  write("torus.obj", obj);
  const json taken = fit("torus.obj", "-o a.ply");
  EXPECT_EQ(taken["solve"]["quads"]["joined"], 288);
  EXPECT_EQ(taken["outputs"][0]["quads"], 288 * 16);
  for (const json& candidate : taken["solve"]["choice"]["candidates"])
    EXPECT_EQ(candidate["faces"], "quads") << "that of triangles was not made";
  EXPECT_THAT(said_, HasSubstr("whose halves they are (--quads off leaves them)"));
  EXPECT_THAT(said_, HasSubstr("288 vertices, 576 faces, 288 with triangles joined (closed"));
  const json asked = fit("torus.obj", "-o o.ply --quads on");
  EXPECT_EQ(asked["outputs"][0]["sha256"], taken["outputs"][0]["sha256"]);
  EXPECT_EQ(asked["solve"]["choice"]["faces_reason"], nullptr);
  EXPECT_THAT(said_, Not(HasSubstr("--quads off")));
  const json left = fit("torus.obj", "-o l.ply --quads off --refine off");
  EXPECT_EQ(left["outputs"][0]["quads"], 2 * 288 * 12);

  // A cage has the mesh's faces; of quads that were asked for it says so, and verify finds them.
  for (const std::string method : {"progressive", "fair"}) {
    for (const auto& [quads, said, other] :
         {std::array{"auto", "off", "on"}, {"on", "on", "off"}}) {
      fit("torus.obj", "--cage c.obj --interpolation " + method + " --quads " + quads);
      EXPECT_THAT(read("c.obj"), HasSubstr("planish quads=" + std::string(said) + "\n"));
      run("verify c.obj torus.obj");
      run(std::string("verify c.obj torus.obj --quads ") + other, 4);
    }
  }
}

// A part's flat faces do not say what its triangles are: both surfaces are made.
TEST_F(Fair, AutoMeasuresQuadsAgainstTrianglesOfParts) {
  write("box.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
        "f 1 4 3\nf 1 3 2\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\n"
        "f 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n");
  const json choice = fit("box.obj", "-o b.ply")["solve"]["choice"];
  ASSERT_EQ(choice["candidates"].size(), 2u);
  for (const json& candidate : choice["candidates"]) EXPECT_LT(candidate["bending"], 1e-6);
  EXPECT_EQ(choice["faces_reason"],
            "triangles joined to quads: all is flat (--quads off leaves them)");
}

// Its own surface is progressive: of the mesh's faces, and sharp where the other is.
TEST_F(Fair, ACageLeavesTheSurfaceBesideItAlone) {
  write("cube.obj", cube_obj());
  for (const std::string input : {"sphere.obj", "cube.obj"}) {
    SCOPED_TRACE(input);
    const json alone = fit(input, "-o a.ply"), both = fit(input, "-o p.ply --cage c.obj");
    EXPECT_EQ(alone["solve"]["method"], "fair");
    EXPECT_EQ(both["outputs"][0]["sha256"], alone["outputs"][0]["sha256"]);
    EXPECT_EQ(both["solve"], alone["solve"]);
    EXPECT_THAT(read("c.obj"), HasSubstr("planish interpolation=progressive\n"));
    run("verify c.obj " + input);
    // And the surface beside does not change the cage.
    const json cage = fit(input, "--cage d.obj");
    EXPECT_EQ(cage["outputs"][0]["sha256"], both["outputs"][1]["sha256"]);
    EXPECT_EQ(cage["solve"]["method"], "progressive");
    EXPECT_THAT(said_, HasSubstr("surface     progressive: the control cage"));
  }
  EXPECT_THAT(read("c.obj"), HasSubstr("planish sharp_edges=0-1 "));
}

// Whatever is sharp stands in the header: of a mesh that another version would find others on.
TEST_F(Fair, ACageSaysWhichEdgesAreSharp) {
  write("cube.obj", cube_obj());
  for (const std::string name : {"c.ply", "c.off"}) {
    fit("cube.obj", "--cage " + name);
    run("verify " + name + " cube.obj");
    run("verify " + name + " cube.obj --creases auto");
    run("verify " + name + " cube.obj --creases use", 5);
    std::string cage = read(name);
    const std::size_t first = cage.find("0-1 ");
    ASSERT_NE(first, std::string::npos) << name;
    write("less_" + name, cage.erase(first, 4));
    run("verify less_" + name + " cube.obj", 5);
  }
}

TEST_F(Fair, AutoSparesTheSecondFitOfSmoothMeshes) {
  write("fine.obj", bumpy_plate_obj(120));
  const json solve = fit("fine.obj", "-o p.ply")["solve"];
  EXPECT_EQ(solve["method"], "progressive");
  EXPECT_EQ(solve["choice"]["candidates"].size(), 1u);
  EXPECT_THAT(said_, HasSubstr("surface     progressive: it does not fold"));
  // At level 0 what was measured for the choice is what the surface is reported with.
  EXPECT_EQ(fit("fine.obj", "-o p.ply --levels 0")["surface"],
            fit("fine.obj",
                "-o p.ply --levels 0 --interpolation progressive --creases "
                "auto:180")["surface"]);
}

}  // namespace
}  // namespace planish::test
