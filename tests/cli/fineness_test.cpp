#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "cli/json_schema.h"
#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/files/mesh_file.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

// The level where nobody names one, and what is said of large files.

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

using nlohmann::json;
using testing::IsEmpty;

class AdaptiveFit : public FolderTest {
 protected:
  json report_of(std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", torus_, "--report", "-"});
    const ProcessResult result = run_planish(flags);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return json::parse(result.out);
  }
  std::string refused(std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", torus_, "-o", path("refused.glb")});
    const ProcessResult result = run_planish(flags);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_FALSE(exists("refused.glb"));
    return result.err;
  }
  std::string torus_ = write("torus.obj", torus_obj(8));
};

TEST_F(AdaptiveFit, SeveralErrorsAreLevelsOfDetail) {
  const json report = report_of({"-o", path("a.glb"), "--chord-error", "1e-4,1e-2"});
  std::ifstream file(PLANISH_REPORT_SCHEMA);
  EXPECT_THAT(schema_problems(report, json::parse(file)), IsEmpty());
  EXPECT_TRUE(exists("a_LOD0.glb"));
  EXPECT_TRUE(exists("a_LOD1.glb"));
  const json& fine = report["outputs"][0];
  const json& coarse = report["outputs"][1];
  EXPECT_TRUE(fine["level"].is_null());
  EXPECT_EQ(fine["chord_error"], 1e-4);
  EXPECT_EQ(coarse["chord_error"], 1e-2);
  EXPECT_EQ(fine["quads"], 0);
  EXPECT_GT(fine["triangles"].get<int>(), 4 * coarse["triangles"].get<int>());
  EXPECT_LT(fine["as_written_error"].get<double>(), 1e-6);
}

TEST_F(AdaptiveFit, EveryFormatHasTheSameTriangles) {
  const json report =
      report_of({"-o", path("a.glb"), "-o", path("a.obj"), "-o", path("a.ply"), "-o", path("a.stl"),
                 "-o", path("a.usda"), "--chord-error", "1e-3", "--angle", "20"});
  for (const json& output : report["outputs"]) {
    EXPECT_EQ(output["triangles"], report["outputs"][0]["triangles"]) << output["path"];
    EXPECT_EQ(output["angle"], 20);
  }
  for (const char* const name : {"a.glb", "a.obj", "a.ply", "a.stl"})
    EXPECT_EQ(read_mesh(path(name)).mesh.face_count(), report["outputs"][0]["triangles"]) << name;
}

TEST_F(AdaptiveFit, FairSurfacesToo) {
  const json report = report_of(
      {"-o", path("a.ply"), "--interpolation", "fair", "--angle", "15", "--creases", "auto:40"});
  EXPECT_EQ(report["outputs"][0]["angle"], 15);
  EXPECT_FALSE(report["outputs"][0].contains("chord_error"));
  EXPECT_GT(report["outputs"][0]["triangles"].get<int>(), 500);
}

TEST_F(AdaptiveFit, ScenesChoose) {
  write("scene.json", R"({"version": 1, "jobs": [{"input": "torus.obj", "report": "r.json",
    "chord_errors": [0.01], "outputs": [{"path": "a.glb"}, {"path": "b.glb", "levels": [1]},
    {"path": "c.glb", "chord_errors": [0.02], "angle": 30}]}]})");
  const ProcessResult result = run_planish({"run", path("scene.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json outputs = read_json("r.json")["outputs"];
  EXPECT_EQ(outputs[0]["chord_error"], 0.01);
  EXPECT_EQ(outputs[1]["level"], 1);
  EXPECT_EQ(outputs[2]["chord_error"], 0.02);
  EXPECT_EQ(outputs[2]["angle"], 30);
}

// A promise as a tolerance is: what is written is flagged.
TEST_F(AdaptiveFit, AnglesThatCannotBeKeptEndWithFive) {
  // A sheet that is folded onto itself.
  torus_ = write("t.obj",
                 "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 0.5 0 0\nv 0.5 1 0\n"
                 "f 1 2 5 4\nf 2 7 8 5\n");
  const ProcessResult result =
      run_planish({"fit", torus_, "-o", path("a.ply"), "--angle", "5", "--report", path("r.json"),
                   "--interpolation", "progressive", "--creases", "use"});
  EXPECT_EQ(result.exit_code, 5) << result.err;
  EXPECT_TRUE(std::filesystem::exists(path("a.ply")));
  const json report = read_json("r.json");
  EXPECT_EQ(report["exit_code"], 5);
  const auto is_it = [](const json& warning) { return warning["code"] == "angle-not-kept"; };
  const json warnings = report["warnings"];
  const auto warning = std::ranges::find_if(warnings, is_it);
  ASSERT_NE(warning, warnings.end()) << warnings;
  EXPECT_THAT((*warning)["message"].get<std::string>(),
              AllOf(HasSubstr("an angle of 5 degrees is not kept beneath "), HasSubstr("near ("),
                    HasSubstr("allow a larger angle")));
}

// Whose faces turn by more than 64 times the angle: triangles are as small as that takes. At the
// tips of vertices of other valence, which may be folds, they end at 2^-7 of half an edge.
TEST_F(AdaptiveFit, SmallAnglesAreKept) {
  torus_ = write("t.obj",
                 "v 1 1 1\nv -1 -1 1\nv -1 1 -1\nv 1 -1 -1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  for (const char* angle : {"1.1", "20"})
    EXPECT_THAT(report_of({"-o", path("a.ply"), "--angle", angle, "-f"})["warnings"], IsEmpty());
}

TEST_F(AdaptiveFit, ContradictionsAreRefusedByName) {
  EXPECT_THAT(refused({"--levels", "2", "--chord-error", "1e-3"}),
              HasSubstr("--levels: a surface has levels or a --chord-error, not both"));
  EXPECT_THAT(refused({"--levels", "2", "--angle", "9"}), HasSubstr("or an --angle, not both"));
  EXPECT_THAT(refused({"--chord-error", "0"}), HasSubstr("--chord-error: 0 is out of range"));
  EXPECT_THAT(refused({"--chord-error", "1e-3,x"}),
              HasSubstr("is no list of chord errors such as 0.01,0.001"));
  EXPECT_THAT(refused({"--chord-error", "1e-3,1e-3"}), HasSubstr("named twice"));
  EXPECT_THAT(refused({"--chord-error", "1e-3,9e-8"}),
              HasSubstr("refused.glb: a chord error of 9e-08 of the diagonal is finer than the "
                        "file's float32 numbers hold; take 1e-7 or more, or write .ply"));
  EXPECT_THAT(refused({"--angle", "200"}), HasSubstr("--angle: 200 is out of range"));
  EXPECT_THAT(refused({"--angle", "10,20"}),
              HasSubstr("is no number; above 0 to 180 degrees are wanted"));
  EXPECT_THAT(refused({"--chord-error", "1e-3", "--scheme", "catmull-clark"}),
              HasSubstr("--chord-error: catmull-clark surfaces come in levels"));
  EXPECT_THAT(refused({"--chord-error", "1e-3", "--attributes", "curvature"}),
              HasSubstr("--attributes: fields are made on levels"));
}

}  // namespace
}  // namespace planish::test
