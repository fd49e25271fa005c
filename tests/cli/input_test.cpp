// What can be given as an input, and what is said of what cannot.
#include <gmock/gmock.h>

#include <cmath>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

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

}  // namespace
}  // namespace planish::test
