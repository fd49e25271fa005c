#include <gmock/gmock.h>

#include <filesystem>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "make_scenes/scene_list.h"

namespace planish::test {
namespace {

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
