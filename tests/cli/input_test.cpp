#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "make_scenes/scene_list.h"

namespace planish::test {
namespace {

// What can be given as an input; what is said of what cannot stands in messages_test.cpp.

using nlohmann::json;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;

using Inputs = FolderTest;

TEST_F(Inputs, AreRecognisedByTheirContent) {
  run("fit - -o out.glb", 0, {.input = cube_obj()});
  EXPECT_THAT(said_, HasSubstr("stdin: 8 vertices, 6 faces"));
  const std::string glb = run("fit - -o - -q", 0, {.input = cube_obj()}).out;
  EXPECT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_THAT(run("inspect -", 0, {.input = glb}).out, HasSubstr("stdin (glb)"));
  write("mesh", cube_obj());
  run("fit mesh -o out.ply");
}

// Three faces at one edge.
TEST_F(Inputs, AreMendedAndTheCageKeepsTheirVerticesFirst) {
  write("fan.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
  const json input = report_of("fit fan.obj -o out.glb --cage cage.obj")["input"];
  EXPECT_THAT(said_, AllOf(HasSubstr("fan.obj: 5 vertices, 9 after separating sheets, 3 faces ("),
                           HasSubstr("non-manifold")));
  EXPECT_EQ(input["vertices"], 5 + 2 * 2);
  EXPECT_EQ(input["changed_faces"], (json{1, 2}));
  run("verify cage.obj fan.obj");
  run("verify cage.obj fan.obj --repair none", 4);
}

TEST_F(Inputs, InspectCountsPoints) {
  std::string cloud;
  for (int i = 0; i < 60; ++i)
    cloud += std::to_string(i % 10) + " " + std::to_string(i / 10) + " 0\n";
  write("scan.xyz", cloud);
  write("scan.ply",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n3 4 0\n");
  for (const char* line : {"inspect scan.xyz", "inspect scan.ply"})
    EXPECT_THAT(run(line).out, AllOf(ContainsRegex("points +"), HasSubstr("spacing")));
  const json said = printed("inspect scan.xyz --json");
  EXPECT_EQ(said["points"], 60);
  EXPECT_NEAR(said["diagonal"].get<double>(), std::sqrt(81.0 + 25.0), 1e-12);
  EXPECT_GE(said["spacing"].get<double>(), 1.0);
  EXPECT_EQ(said["bounds"], json::parse("[[0, 0, 0], [9, 5, 0]]"));
}

TEST_F(Inputs, InspectSaysWhatAFileCarries) {
  write("mapped.obj",
        "v 1 2 3 1 0 0\nv 2 2 3 0 1 0\nv 1 4 3 0 0 1\nv 2 4 3.5 1 1 1\nvt 0 0\nvt 1 0\nvt 0 1\n"
        "usemtl steel\nf 1/1 2/2 3/3\nusemtl wood\nf 3/3 2/2 4/1\n");
  const json mesh = printed("inspect mapped.obj --json");
  EXPECT_EQ(mesh["bounds"], json::parse("[[1, 2, 3], [2, 4, 3.5]]"));
  expect_values(mesh, {{"/texture_points", 3}, {"/colors", 4}});
  EXPECT_EQ(mesh["materials"], json::parse(R"(["steel", "wood"])"));
  EXPECT_THAT(run("inspect mapped.obj").out,
              AllOf(ContainsRegex("bounds +\\(1, 2, 3\\) to \\(2, 4, 3.5\\)"),
                    ContainsRegex("materials +2")));
  write("cloud.ply",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
        "0 0 7 0 0 1 255 0 0\n4 0 7 0 0 1 255 0 0\n");
  const json points = printed("inspect cloud.ply --json");
  EXPECT_EQ(points["bounds"], json::parse("[[0, 0, 7], [4, 0, 7]]"));
  expect_values(points, {{"/normals", 2}, {"/colors", 2}});
}

TEST_F(Inputs, InspectTakesSeveralFilesAndNamesHoles) {
  write("a.obj", cube_obj());
  write("b.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nf 1 2 3 4\nf 2 5 6 3\n"
        "t hole 1/0/0 1\n");
  EXPECT_THAT(
      run("inspect a.obj none.obj b.obj", 3).out,
      AllOf(HasSubstr("a.obj (obj)"), HasSubstr("b.obj (obj)"), ContainsRegex("hole faces +1")));
  EXPECT_THAT(said_, HasSubstr("none.obj"));
  const json said = printed("inspect --json a.obj b.obj");
  ASSERT_EQ(said.size(), 2u);
  EXPECT_EQ(said[1]["hole_faces"], 1);
}

#ifdef PLANISH_HAS_MESHER
TEST_F(Inputs, PointsComeByStdinAndUnderAnyName) {
  std::string cloud;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j)
      cloud +=
          std::to_string(i) + " " + std::to_string(j) + " " + std::to_string(0.01 * i * j) + "\n";
  write("scan.dat", cloud);
  run("fit scan.dat -o out.glb");
  const std::string report = run("fit - --input-format xyz --report - -q", 0, {.input = cloud}).out;
  EXPECT_EQ(json::parse(report)["reconstruction"]["points"], 900);
}
#endif

// "inspect x && fit x" fits what fit can.
TEST_F(Inputs, InspectEndsAsFitDoes) {
  write("two.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 1 2\n");
  EXPECT_THAT(run("inspect two.obj").out,
              AllOf(HasSubstr("1, which fit mends with a warning"), HasSubstr("duplicate-face")));
  const json said = printed("inspect two.obj --json");
  expect_values(
      said,
      {{"/problems/0/kind", "duplicate-face"}, {"/problems/0/element", 1}, {"/mended", true}});
  run("fit two.obj -o two.glb");
  write("thin.obj", "v 0 0 0\nv 1 0 0\nf 1 2 1\n");
  EXPECT_EQ(printed("inspect thin.obj --json", 4)["mended"], false);
  run("fit thin.obj -o thin.glb", 4);
}

TEST_F(Inputs, InspectCountsASoundMesh) {
  write("torus.obj", torus_obj(10));
  EXPECT_THAT(run("inspect torus.obj").out, ContainsRegex("genus +1"));
  const json said = printed("inspect torus.obj --json");
  expect_values(said, {{"/vertices", 100}, {"/edges", 200}, {"/genus", 1}});
  EXPECT_EQ(said["valences"], (json{{"4", 100}}));
  EXPECT_EQ(said["boundary_loops"], 0);
  EXPECT_TRUE(said["problems"].empty());
}

TEST_F(Inputs, BadScenesEndAsTheirListSays) {
  for (const shapes::BadFile& bad : shapes::bad_files()) {
    const std::string line = "fit " PLANISH_SCENES "/bad/" + bad.file + " -o a.glb -f";
    run(line, bad.repaired);
    EXPECT_FALSE(said_.empty()) << bad.file << " needs an error or a warning";
    EXPECT_EQ(exists("a.glb"), bad.repaired == 0) << bad.file;
    run(line + " --repair none", bad.exit_code);
    std::filesystem::remove(path("a.glb"));
  }
}

TEST_F(Inputs, ACubeWithHolesKeepsItsPlanesAndEdges) {
  const json report =
      report_of("fit " PLANISH_SCENES "/cube_with_holes.obj --creases auto -o c.ply");
  EXPECT_EQ(report["solve"]["iterations"], 0);
  EXPECT_LT(report["solve"]["error"]["max"], 1e-6);
  EXPECT_EQ(report["surface"]["folded_area"], 0.0);
  EXPECT_GT(report["input"]["corners"], 0);
}

TEST_F(Inputs, AMechanicalPartConvergesInAFewStepsWithBothWeights) {
  const std::string part = PLANISH_SCENES "/bearing_block.obj";
  const std::string fit = "fit " + part + " --creases auto --cage cage.obj";
  for (const std::string weights : {"doo-sabin", "averaged"}) {
    for (const std::string device : {"cpu", "vulkan"}) {
      if (device == "vulkan" && !has_vulkan()) continue;
      const json report = report_of(fit + " --weights " + weights + " --device " + device);
      EXPECT_LE(report["solve"]["iterations"], 8) << weights << " on " << device;
      run("verify cage.obj " + part);
    }
  }
}

TEST_F(Inputs, TagsOfASceneFileCountAsTheFilesOwn) {
  write("cube.obj", cube_obj());
  write("scene.json", R"({"version": 1, "jobs": [
    {"input": "cube.obj", "report": "r.json", "outputs": [{"path": "cage.obj", "what": "cage"}],
     "solve": {"crease_edges": [[0, 1]], "corner_vertices": [7]}}]})");
  run("run scene.json");
  EXPECT_EQ(read_json("r.json")["input"]["sharp_edges"], 1);
  EXPECT_EQ(read_json("r.json")["input"]["corners"], 1);
  EXPECT_THAT(read("cage.obj"), HasSubstr("t crease"));
}

}  // namespace
}  // namespace planish::test
