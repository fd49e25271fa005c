#include <gmock/gmock.h>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

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

}  // namespace
}  // namespace planish::test
