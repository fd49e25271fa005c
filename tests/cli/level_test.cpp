// The level where nobody names one, and what is said of large files.
#include <gmock/gmock.h>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/files/mesh_file.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class LevelByDensity : public FolderTest {
 protected:
  // Of 20,000 quads that turn by 4 degrees at most, and of as many and more that turn by 22.
  std::string dense() { return written("dense.ply", torus(200, 100, 1, 0.4)); }
  std::string strips() { return written("strips.ply", torus(1500, 16, 1, 0.4)); }
  std::string coarse() { return written("coarse.ply", torus(20, 10, 1, 0.4)); }

  ProcessResult fit(const std::string& input, std::vector<std::string> more) {
    std::vector<std::string> arguments{
        "fit", input,      "--device",     "cpu", "--quads",         "off",        "--creases",
        "use", "--report", path("r.json"), "-f",  "--interpolation", "progressive"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_planish(arguments);
  }
  nlohmann::json output() { return read_json("r.json")["outputs"][0]; }

 private:
  std::string written(const char* name, const PolygonMesh& mesh) {
    write_mesh(path(name), FileFormat::Ply, mesh);
    return path(name);
  }
};

TEST_F(LevelByDensity, IsOneOfADenseMesh) {
  const ProcessResult result = fit(dense(), {"-o", path("o.glb")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("level       1: the mesh is dense, faces of 100 % of its area "
                                    "turn by less than 20 degrees (--levels 2 is finer)"));
  EXPECT_EQ(output()["level"], 1);
  EXPECT_EQ(output()["quads"], 4 * 20'000);
  const nlohmann::json density = read_json("r.json")["density"];
  EXPECT_EQ(density, (nlohmann::json{{"vertices", 20'000}, {"even_area", 1.0}, {"level", 1}}));
}

TEST_F(LevelByDensity, IsTwoOfOthersAndWhatIsNamed) {
  const ProcessResult coarse_one = fit(coarse(), {"-o", path("o.glb"), "--levels", "auto"});
  EXPECT_EQ(output()["level"], 2);
  EXPECT_FALSE(read_json("r.json").contains("density"));
  EXPECT_THAT(coarse_one.err, Not(HasSubstr("dense")));
  const ProcessResult named = fit(dense(), {"-o", path("o.glb"), "--levels", "2"});
  EXPECT_EQ(output()["level"], 2);
  EXPECT_THAT(named.err, AllOf(Not(HasSubstr("is dense")), Not(HasSubstr("times the input"))));
}

TEST_F(LevelByDensity, IsThatOfASceneAndOfADryRun) {
  (void)dense();
  write("s.json", R"({"version": 1, "defaults": {"levels": [0], "device": "cpu"}, "jobs": [
    {"input": "dense.ply", "report": "r.json", "interpolation": "progressive",
     "outputs": [{"path": "a.glb", "levels": "auto"}, {"path": "b.glb"}]}]})");
  ASSERT_EQ(run_planish({"run", path("s.json")}).exit_code, 0);
  EXPECT_EQ(output()["level"], 1);
  EXPECT_EQ(read_json("r.json")["outputs"][1]["level"], 0);
  EXPECT_THAT(fit(dense(), {"-o", path("d.glb"), "--dry-run"}).out,
              HasSubstr("(level 1, 80,000 vertices, 80,000 quads"));
}

TEST_F(LevelByDensity, OtherWordsAreRefused) {
  EXPECT_THAT(fit(coarse(), {"-o", path("o.glb"), "--levels", "automatic"}).err,
              HasSubstr("--levels: \"automatic\" is no list of levels such as 3,1, and not auto"));
}

TEST_F(LevelByDensity, LargeFilesThatNobodyAskedForAreNamed) {
  const ProcessResult result = fit(strips(), {"-o", path("o.obj")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, testing::ContainsRegex("o.obj: is [0-9.]+ MiB, [0-9]+ times the input; "
                                                 "--levels 1 writes about a quarter of that"));
  EXPECT_EQ(read_json("r.json")["warnings"][0]["code"], "large-output");
  EXPECT_THAT(fit(strips(), {"-o", path("o.obj"), "--levels", "2"}).err,
              Not(HasSubstr("times the input")));
}

}  // namespace
}  // namespace planish::test
