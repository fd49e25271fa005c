#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "make_scenes/scene_list.h"

namespace planish::test {
namespace {

// What can be given as an input, and what is said of what cannot.

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

class Inputs : public FolderTest {
 protected:
  ProcessResult fit(const std::string& input, const std::string& content = {}) const {
    return run_planish({"fit", input, "-o", "out.glb", "--device", "cpu", "-f"},
                       {.input = content, .environment = {}, .folder = path("")});
  }
  void expect_error(const std::string& input, int exit_code, const std::string& part) const {
    const ProcessResult result = fit(input);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_THAT(result.err, HasSubstr(part));
  }
};

TEST_F(Inputs, StdinIsRecognisedByItsContent) {
  const ProcessResult result = fit("-", cube_obj());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("stdin: 8 vertices, 6 faces"));
  const ProcessResult piped =
      run_planish({"fit", "-", "-o", "-", "-q"}, {.input = cube_obj(), .environment = {}});
  EXPECT_EQ(piped.out.substr(0, 4), "glTF");
  const ProcessResult again =
      run_planish({"inspect", "-"}, {.input = piped.out, .environment = {}});
  EXPECT_THAT(again.out, HasSubstr("stdin (glb)"));
}

TEST_F(Inputs, AFileWithoutAnExtensionIsRecognisedByItsContent) {
  write("mesh", cube_obj());
  EXPECT_EQ(fit("mesh").exit_code, 0);
  write("text", "hello\n");
  expect_error("text", 3, "neither name nor content is that of a format that is read");
}

TEST_F(Inputs, AMissingFileNamesItsNearest) {
  write("goblet.obj", cube_obj());
  expect_error("goblt.obj", 3,
               "goblt.obj: cannot read: No such file or directory; did you mean "
               "goblet.obj?");
  expect_error("GOBLET.OBJ", 3, "did you mean goblet.obj?");
  expect_error("~/goblet.obj", 3, "the shell puts a home folder in place of ~");
  expect_error("file:///tmp/a.obj", 3, "a path is wanted, not a URL: /tmp/a.obj");
}

TEST_F(Inputs, FormatsOfOthersAreToldHowToGetHere) {
  write("part.STEP", "ISO-10303-21;");
  expect_error("part.STEP", 2,
               "STEP is not read (glb, gltf, obj, ply, off, stl, xyz, pts, pcd, las, ptx "
               "are); FreeCAD or gmsh converts it");
  write("part.fbx", "Kaydara");
  expect_error("part.fbx", 2, "\"assimp export part.fbx part.glb\" converts it");
  write("hill.laz", "LASF");
  expect_error("hill.laz", 2, "\"pdal translate hill.laz hill.las\" converts it");
  write("room.e57", "ASTM-E57");
  expect_error("room.e57", 2,
               "\"CloudCompare -SILENT -O room.e57 -C_EXPORT_FMT PLY -SAVE_CLOUDS\" converts it");
}

TEST_F(Inputs, AFolderWithoutMeshesSaysWhatIsRead) {
  expect_error(".", 3,
               "this folder holds no file that is read (.glb .gltf .obj .ply .off .stl .xyz "
               ".pts .pcd .las .ptx)");
}

TEST_F(Inputs, RandomBytesAreNoJson) {
  write("random.glb", "\x02\xF1zz");
  const ProcessResult result = fit("random.glb");
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("starts neither with glTF nor with {"));
}

TEST_F(Inputs, CountsAreTheFilesOwnWithWhatMendingMadeOfThem) {
  // Three faces at one edge.
  write("fan.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
  EXPECT_THAT(fit("fan.obj").err,
              HasSubstr("fan.obj: 5 vertices, 9 after separating sheets, 3 faces ("));
}

TEST_F(Inputs, InspectCountsPoints) {
  std::string cloud;
  for (int i = 0; i < 60; ++i)
    cloud += std::to_string(i % 10) + " " + std::to_string(i / 10) + " 0\n";
  write("scan.xyz", cloud);
  write("scan.ply",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n3 4 0\n");
  for (const std::string name : {"scan.xyz", "scan.ply"}) {
    const ProcessResult text = run_planish({"inspect", path(name)});
    EXPECT_EQ(text.exit_code, 0) << text.err;
    EXPECT_THAT(text.out, AllOf(testing::ContainsRegex("points +"), HasSubstr("spacing")));
  }
  const auto json = nlohmann::json::parse(run_planish({"inspect", path("scan.xyz"), "--json"}).out);
  EXPECT_EQ(json["points"], 60);
  EXPECT_NEAR(json["diagonal"].get<double>(), std::sqrt(81.0 + 25.0), 1e-12);
  EXPECT_GE(json["spacing"].get<double>(), 1.0);
  EXPECT_EQ(json["bounds"], nlohmann::json::parse("[[0, 0, 0], [9, 5, 0]]"));
}

TEST_F(Inputs, InspectSaysWhatAFileCarries) {
  write("mapped.obj",
        "v 1 2 3 1 0 0\nv 2 2 3 0 1 0\nv 1 4 3 0 0 1\nv 2 4 3.5 1 1 1\nvt 0 0\nvt 1 0\nvt 0 1\n"
        "usemtl steel\nf 1/1 2/2 3/3\nusemtl wood\nf 3/3 2/2 4/1\n");
  const auto mesh =
      nlohmann::json::parse(run_planish({"inspect", path("mapped.obj"), "--json"}).out);
  EXPECT_EQ(mesh["bounds"], nlohmann::json::parse("[[1, 2, 3], [2, 4, 3.5]]"));
  EXPECT_EQ(mesh["texture_points"], 3);
  EXPECT_EQ(mesh["colors"], 4);
  EXPECT_EQ(mesh["materials"], nlohmann::json::parse(R"(["steel", "wood"])"));
  EXPECT_THAT(run_planish({"inspect", path("mapped.obj")}).out,
              AllOf(testing::ContainsRegex("bounds +\\(1, 2, 3\\) to \\(2, 4, 3.5\\)"),
                    testing::ContainsRegex("materials +2")));
  std::string cloud =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  for (int i = 0; i < 5; ++i) cloud += std::to_string(i) + " 0 7 0 0 1 255 0 0\n";
  write("cloud.ply", cloud);
  const auto points =
      nlohmann::json::parse(run_planish({"inspect", path("cloud.ply"), "--json"}).out);
  EXPECT_EQ(points["bounds"], nlohmann::json::parse("[[0, 0, 7], [4, 0, 7]]"));
  EXPECT_EQ(points["normals"], 5);
  EXPECT_EQ(points["colors"], 5);
}

TEST_F(Inputs, InspectTakesSeveralFilesAndNamesHoles) {
  write("a.obj", cube_obj());
  write("b.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nf 1 2 3 4\nf 2 5 6 3\n"
        "t hole 1/0/0 1\n");
  const ProcessResult text =
      run_planish({"inspect", path("a.obj"), path("none.obj"), path("b.obj")});
  EXPECT_EQ(text.exit_code, 3);
  EXPECT_THAT(text.err, HasSubstr("none.obj"));
  EXPECT_THAT(text.out, AllOf(HasSubstr("a.obj (obj)"), HasSubstr("b.obj (obj)"),
                              testing::ContainsRegex("hole faces +1")));
  const auto json =
      nlohmann::json::parse(run_planish({"inspect", "--json", path("a.obj"), path("b.obj")}).out);
  ASSERT_EQ(json.size(), 2u);
  EXPECT_EQ(json[1]["hole_faces"], 1);
}

TEST_F(Inputs, PointsWhereAMeshIsWantedSayWhatMakesOne) {
  write("cage.obj", cube_obj());
  write("two.xyz", "0 0 0\n1 1 1\n");
  const ProcessResult result = run_planish({"verify", path("cage.obj"), path("two.xyz")});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("holds points, and a mesh is wanted here"));
}

#ifdef PLANISH_HAS_MESHER
TEST_F(Inputs, PointsComeByStdinAndUnderAnyName) {
  std::string cloud;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j)
      cloud +=
          std::to_string(i) + " " + std::to_string(j) + " " + std::to_string(0.01 * i * j) + "\n";
  write("scan.dat", cloud);
  EXPECT_EQ(fit("scan.dat").exit_code, 0);
  const ProcessResult piped =
      run_planish({"fit", "-", "--input-format", "xyz", "--report", "-", "-q"},
                  {.input = cloud, .environment = {}});
  EXPECT_EQ(piped.exit_code, 0) << piped.err;
  EXPECT_EQ(nlohmann::json::parse(piped.out)["reconstruction"]["points"], 900);
}
#endif

using testing::ElementsAre;

class BrokenInput : public FolderTest {
 protected:
  // Fits the content; only the input may be there afterwards.
  ProcessResult fit(const std::string& name, const std::string& content) {
    const std::string input = write(name, content);
    ProcessResult result = run_planish({"fit", input, "-o", path("out.glb"), "--cage",
                                        path("out.obj"), "--report", path("out.json")});
    EXPECT_THAT(names(), ElementsAre(name));
    return result;
  }
};

TEST_F(BrokenInput, AMissingFileExitsThree) {
  const ProcessResult result = run_planish({"fit", path("none.obj"), "-o", path("out.glb")});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, AllOf(HasSubstr("none.obj"), HasSubstr("No such file")));
}

TEST_F(BrokenInput, AFolderExitsThree) {
  EXPECT_EQ(run_planish({"fit", path(""), "--input-format", "obj", "-o", path("a.glb")}).exit_code,
            3);
}

TEST_F(BrokenInput, MalformedTextNamesTheLine) {
  const ProcessResult result = fit("bad.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("bad.obj:2: "));
}

TEST_F(BrokenInput, AnIndexOutOfRangeExitsThree) {
  EXPECT_EQ(fit("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n").exit_code, 3);
}

TEST_F(BrokenInput, AShortPlyExitsThree) {
  EXPECT_EQ(fit("bad.ply",
                "ply\nformat binary_little_endian 1.0\nelement vertex 1000\nproperty float x\n"
                "property float y\nproperty float z\nelement face 1\n"
                "property list uchar int vertex_indices\nend_header\n1234")
                .exit_code,
            3);
}

// Three faces at one edge.
constexpr const char* kFan =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\n";

TEST_F(BrokenInput, IsRepairedWithAWarningAndTheCageKeepsTheInputsVerticesFirst) {
  const std::string input = write("fan.obj", kFan);
  const ProcessResult result = run_planish({"fit", input, "-o", path("out.glb"), "--cage",
                                            path("cage.obj"), "--report", path("report.json")});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("non-manifold"));
  const nlohmann::json report = read_json("report.json");
  EXPECT_EQ(report["input"]["vertices"], 5 + 2 * 2);
  EXPECT_EQ(report["input"]["changed_faces"], (nlohmann::json{1, 2}));
  EXPECT_EQ(run_planish({"verify", path("cage.obj"), input}).exit_code, 0);
  EXPECT_EQ(run_planish({"verify", path("cage.obj"), input, "--repair", "none"}).exit_code, 4);
}

TEST_F(BrokenInput, AMeshWithoutASurfaceExitsFourAndNamesFileAndElements) {
  const std::string input = write("fan.obj", kFan);
  const ProcessResult result =
      run_planish({"fit", input, "-o", path("out.glb"), "--repair", "none"});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, AllOf(HasSubstr("fan.obj"), HasSubstr("face")));
}

TEST_F(BrokenInput, NoFacesExitsFour) { EXPECT_EQ(fit("a.obj", "v 0 0 0\n").exit_code, 4); }

TEST_F(BrokenInput, CoincidentVerticesExitFour) {
  const std::string input = write("a.obj", "v 1 2 3\nv 1 2 3\nv 1 2 3\nf 1 2 3\n");
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"fit", input, "-o", path("out.glb")},
        {"fit", input, "-o", path("out.glb"), "--interpolation", "fair", "--repair", "none"},
        {"inspect", input}}) {
    const ProcessResult result = run_planish(command);
    EXPECT_EQ(result.exit_code, 4) << command[0];
    EXPECT_THAT(result.out + result.err, HasSubstr("all vertices of the faces are at (1, 2, 3)"));
  }
  write("scene.json", R"({"version":1,"jobs":[{"input":"a.obj","outputs":[{"path":"out.glb"}]}]})");
  const ProcessResult run = run_planish({"run", path("scene.json")});
  EXPECT_EQ(run.exit_code, 8);
  EXPECT_THAT(run.err, HasSubstr("all vertices of the faces are at (1, 2, 3)"));
  EXPECT_THAT(names(), ElementsAre("a.obj", "scene.json"));
}

TEST_F(BrokenInput, MoreThanTheMachineHasExitsSix) {
  // 562,500 quads are 2.3e9 at level 6, more than 32-bit indices reach.
  const ProcessResult result = [&] {
    const std::string input = write("large.obj", torus_obj(750));
    return run_planish({"fit", input, "-o", path("out.glb"), "--levels", "6"});
  }();
  EXPECT_EQ(result.exit_code, 6);
  EXPECT_THAT(result.err, HasSubstr("planish: error: "));
  EXPECT_THAT(names(), ElementsAre("large.obj"));
}

// "inspect x && fit x" fits what fit can.
TEST_F(BrokenInput, InspectEndsAsFitDoes) {
  const std::string mended = write("two.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 1 2\n");
  const ProcessResult text = run_planish({"inspect", mended});
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_THAT(text.out,
              AllOf(HasSubstr("1, which fit mends with a warning"), HasSubstr("duplicate-face")));
  const auto said = nlohmann::json::parse(run_planish({"inspect", mended, "--json"}).out);
  EXPECT_EQ(said["problems"][0]["kind"], "duplicate-face");
  EXPECT_EQ(said["problems"][0]["element"], 1);
  EXPECT_EQ(said["mended"], true);
  EXPECT_EQ(run_planish({"fit", mended, "-o", path("two.glb")}).exit_code, 0);
  const std::string refused = write("thin.obj", "v 0 0 0\nv 1 0 0\nf 1 2 1\n");
  const ProcessResult without = run_planish({"inspect", refused, "--json"});
  EXPECT_EQ(without.exit_code, 4);
  EXPECT_EQ(nlohmann::json::parse(without.out)["mended"], false);
  EXPECT_EQ(run_planish({"fit", refused, "-o", path("thin.glb")}).exit_code, 4);
}

TEST_F(BrokenInput, InspectCountsASoundMesh) {
  const std::string input = write("torus.obj", torus_obj(10));
  const ProcessResult text = run_planish({"inspect", input});
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_THAT(text.out, testing::ContainsRegex("genus +1"));
  const nlohmann::json said = nlohmann::json::parse(run_planish({"inspect", input, "--json"}).out);
  EXPECT_EQ(said["vertices"], 100);
  EXPECT_EQ(said["edges"], 200);
  EXPECT_EQ(said["genus"], 1);
  EXPECT_EQ(said["valences"], (nlohmann::json{{"4", 100}}));
  EXPECT_EQ(said["boundary_loops"], 0);
  EXPECT_TRUE(said["problems"].empty());
}

class BadScenes : public FolderTest {};

TEST_F(BadScenes, EndAsTheirListSays) {
  for (const shapes::BadFile& bad : shapes::bad_files()) {
    SCOPED_TRACE(bad.file);
    const std::string file = std::string(PLANISH_SCENES) + "/bad/" + bad.file;
    const ProcessResult repaired = run_planish({"fit", file, "-o", path("a.glb"), "-f"});
    EXPECT_EQ(repaired.exit_code, bad.repaired) << repaired.err;
    EXPECT_FALSE(repaired.err.empty()) << "needs an error or a warning";
    EXPECT_EQ(exists("a.glb"), repaired.exit_code == 0);
    std::filesystem::remove(path("a.glb"));
    const ProcessResult refused =
        run_planish({"fit", file, "-o", path("a.glb"), "--repair", "none"});
    EXPECT_EQ(refused.exit_code, bad.exit_code) << refused.err;
    std::filesystem::remove(path("a.glb"));
  }
}

class SharpScenes : public FolderTest {};

TEST_F(SharpScenes, ACubeWithHolesKeepsItsPlanesAndEdges) {
  const std::string cube = std::string(PLANISH_SCENES) + "/cube_with_holes.obj";
  const ProcessResult result = run_planish(
      {"fit", cube, "--creases", "auto", "-o", path("c.ply"), "--report", path("c.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json report = read_json("c.json");
  EXPECT_EQ(report["solve"]["iterations"], 0);
  EXPECT_LT(report["solve"]["error"]["max"], 1e-6);
  EXPECT_EQ(report["surface"]["folded_area"], 0.0);
  EXPECT_GT(report["input"]["corners"], 0);
}

TEST_F(SharpScenes, AMechanicalPartConvergesInAFewStepsWithBothWeights) {
  const std::string part = std::string(PLANISH_SCENES) + "/bearing_block.obj";
  for (const std::string weights : {"doo-sabin", "averaged"}) {
    for (const std::string device : {"cpu", "vulkan"}) {
      const ProcessResult result =
          run_planish({"fit", part, "--creases", "auto", "--weights", weights, "--device", device,
                       "--cage", path("cage.obj"), "--report", path("p.json"), "-f"});
      if (device == "vulkan" && result.exit_code == 6) continue;  // the vulkan tests ask for one
      ASSERT_EQ(result.exit_code, 0) << result.err;
      EXPECT_LE(read_json("p.json")["solve"]["iterations"], 8) << weights << " on " << device;
      EXPECT_EQ(run_planish({"verify", path("cage.obj"), part}).exit_code, 0);
    }
  }
}

TEST_F(SharpScenes, TagsOfASceneFileCountAsTheFilesOwn) {
  write("cube.obj", cube_obj());
  write("scene.json", R"({"version": 1, "jobs": [
    {"input": "cube.obj", "report": "tagged.json", "outputs": [{"path": "cage.obj", "what": "cage"}],
     "solve": {"crease_edges": [[0, 1]], "corner_vertices": [7]}}]})");
  ASSERT_EQ(run_planish({"run", path("scene.json")}).exit_code, 0);
  EXPECT_EQ(read_json("tagged.json")["input"]["sharp_edges"], 1);
  EXPECT_EQ(read_json("tagged.json")["input"]["corners"], 1);
  EXPECT_THAT(read("cage.obj"), testing::HasSubstr("t crease"));

  write("wrong.json", R"({"version": 1, "jobs": [
    {"input": "cube.obj", "report": "r.json", "crease_edges": [[0, 8]]}]})");
  const ProcessResult wrong = run_planish({"run", path("wrong.json")});
  EXPECT_EQ(wrong.exit_code, 8);
  EXPECT_THAT(wrong.err, testing::HasSubstr("crease_edges of the scene names vertex 8 of 8"));
}

}  // namespace
}  // namespace planish::test
