#include <gmock/gmock.h>

#include <algorithm>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/asset_sample.h"
#include "planish/files/mesh_file.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

// The level where nobody names one.

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class LevelByDensity : public FolderTest {
 protected:
  // Of 20,000 quads that turn by 4 degrees at most, and of 200.
  void SetUp() override {
    write_mesh(path("dense.ply"), FileFormat::Ply, torus(200, 100, 1, 0.4));
    write_mesh(path("coarse.ply"), FileFormat::Ply, torus(20, 10, 1, 0.4));
  }
  json fit(const std::string& flags) {
    return report_of("fit --quads off --creases use --interpolation progressive " + flags);
  }
};

TEST_F(LevelByDensity, IsOneOfADenseMesh) {
  const json report = fit("dense.ply -o o.glb");
  EXPECT_THAT(said_,
              HasSubstr("level       1: the mesh is dense, faces of 100 % of its area turn by "
                        "less than 20 degrees (--levels 2 is finer)"));
  EXPECT_EQ(report["outputs"][0]["level"], 1);
  EXPECT_EQ(report["outputs"][0]["quads"], 4 * 20'000);
  EXPECT_EQ(report["density"], (json{{"vertices", 20'000}, {"even_area", 1.0}, {"level", 1}}));
  EXPECT_THAT(run("fit dense.ply --quads off -o d.glb --dry-run").out,
              HasSubstr("(level 1, 80,000 vertices, 80,000 quads"));
}

TEST_F(LevelByDensity, IsTwoOfOthersAndWhatIsNamed) {
  const json report = fit("coarse.ply -o o.glb --levels auto");
  EXPECT_EQ(report["outputs"][0]["level"], 2);
  EXPECT_FALSE(report.contains("density"));
  EXPECT_THAT(said_, Not(HasSubstr("dense")));
  EXPECT_EQ(fit("dense.ply -o o.glb --levels 2")["outputs"][0]["level"], 2);
  EXPECT_THAT(said_, AllOf(Not(HasSubstr("is dense")), Not(HasSubstr("times the input"))));
}

TEST_F(LevelByDensity, IsThatOfAScene) {
  write("s.json", R"({"version": 1, "defaults": {"levels": [0]}, "jobs": [
    {"input": "dense.ply", "report": "r.json", "interpolation": "progressive",
     "outputs": [{"path": "a.glb", "levels": "auto"}, {"path": "b.glb"}]}]})");
  run("run s.json");
  EXPECT_EQ(read_json("r.json")["outputs"][0]["level"], 1);
  EXPECT_EQ(read_json("r.json")["outputs"][1]["level"], 0);
}

class AdaptiveFit : public FolderTest {
 protected:
  std::string torus_ = write("torus.obj", torus_obj(8));
};

TEST_F(AdaptiveFit, SeveralErrorsAreLevelsOfDetail) {
  const json outputs = report_of("fit torus.obj -o a.glb --chord-error 1e-4,1e-2")["outputs"];
  EXPECT_TRUE(exists("a_LOD0.glb"));
  EXPECT_TRUE(exists("a_LOD1.glb"));
  const json &fine = outputs[0], &coarse = outputs[1];
  EXPECT_TRUE(fine["level"].is_null());
  EXPECT_EQ(fine["chord_error"], 1e-4);
  EXPECT_EQ(coarse["chord_error"], 1e-2);
  EXPECT_EQ(fine["quads"], 0);
  EXPECT_GT(fine["triangles"].get<int>(), 4 * coarse["triangles"].get<int>());
  EXPECT_LT(fine["as_written_error"].get<double>(), 1e-6);
}

TEST_F(AdaptiveFit, EveryFormatHasTheSameTriangles) {
  const json outputs = report_of(
      "fit torus.obj -o a.glb -o a.obj -o a.ply -o a.stl -o a.usda "
      "--chord-error 1e-3 --angle 20")["outputs"];
  for (const json& output : outputs) {
    EXPECT_EQ(output["triangles"], outputs[0]["triangles"]) << output["path"];
    EXPECT_EQ(output["angle"], 20);
  }
  for (const char* const name : {"a.glb", "a.obj", "a.ply", "a.stl"})
    EXPECT_EQ(read_mesh(path(name)).mesh.face_count(), outputs[0]["triangles"]) << name;
}

TEST_F(AdaptiveFit, FairSurfacesToo) {
  const json output = report_of(
      "fit torus.obj -o a.ply --interpolation fair --angle 15 --creases "
      "auto:40")["outputs"][0];
  EXPECT_EQ(output["angle"], 15);
  EXPECT_FALSE(output.contains("chord_error"));
  EXPECT_GT(output["triangles"].get<int>(), 500);
}

TEST_F(AdaptiveFit, ScenesChoose) {
  write("scene.json", R"({"version": 1, "jobs": [{"input": "torus.obj", "report": "r.json",
    "chord_errors": [0.01], "outputs": [{"path": "a.glb"}, {"path": "b.glb", "levels": [1]},
    {"path": "c.glb", "chord_errors": [0.02], "angle": 30}]}]})");
  run("run scene.json");
  const json outputs = read_json("r.json")["outputs"];
  expect_values(
      outputs,
      {{"/0/chord_error", 0.01}, {"/1/level", 1}, {"/2/chord_error", 0.02}, {"/2/angle", 30}});
}

// Of 64 quads.
class DecimatedFit : public AdaptiveFit {};

TEST_F(DecimatedFit, EveryFormatHasAsManyTrianglesAsAreWanted) {
  const json report =
      report_of("fit torus.obj -o a.glb -o a.obj -o a.ply -o a.stl -o a.usda -o a.off --faces 100");
  for (const json& output : report["outputs"]) {
    EXPECT_EQ(output["triangles"], 100) << output["path"];
    expect_values(output, {{"/level", nullptr}, {"/decimated/faces", 100}});
    EXPECT_GT(output["decimated"]["max_distance"].get<double>(), 1e-3);
    EXPECT_LT(output["decimated"]["max_distance"].get<double>(), 0.1);
    EXPECT_LT(output["as_written_error"].get<double>(), 1e-6);
  }
  for (const char* const name : {"a.glb", "a.obj", "a.ply", "a.stl", "a.off"})
    EXPECT_EQ(read_mesh(path(name)).mesh.face_count(), 100) << name;
  EXPECT_THAT(said_, AllOf(HasSubstr("at most 100 faces, "), HasSubstr("100 triangles, within "),
                           HasSubstr(" of the diagonal")));
}

TEST_F(DecimatedFit, SeveralAreLevelsOfDetailFromBelowTheInputToAbove) {
  const json outputs = report_of("fit torus.obj -o a.ply --faces 2000,60")["outputs"];
  EXPECT_TRUE(exists("a_LOD0.ply"));
  EXPECT_TRUE(exists("a_LOD1.ply"));
  EXPECT_EQ(outputs[0]["triangles"], 2000);
  EXPECT_EQ(outputs[1]["triangles"], 60);
  EXPECT_GT(outputs[1]["decimated"]["max_distance"].get<double>(),
            5 * outputs[0]["decimated"]["max_distance"].get<double>());
}

TEST_F(DecimatedFit, PixelsAreAShareOfTheView) {
  const json output = report_of("fit torus.obj -o a.ply --pixels 2@500")["outputs"][0];
  EXPECT_EQ(output["decimated"]["distance"], 0.004);
  EXPECT_LE(output["decimated"]["max_distance"].get<double>(), 0.004);
  EXPECT_GT(output["decimated"]["max_distance"].get<double>(), 0.001);
}

// Each mesh has its part of the triangles; nodes name all levels of detail.
TEST_F(DecimatedFit, MeshesOfAnAssetShareTheFaces) {
  AssetSample sample;
  write("a.glb", sample.glb());
  const json report = report_of("fit a.glb -o b.glb --faces 600,200 --lods msft");
  const json& output = report["outputs"][0];
  EXPECT_LE(output["triangles"], 800);
  EXPECT_GT(output["triangles"], 600);
  EXPECT_EQ(output["decimated"]["faces"], 600);
  EXPECT_EQ(output["coarser"][0]["decimated"]["faces"], 200);
  EXPECT_GT(output["coarser"][0]["decimated"]["max_distance"], output["decimated"]["max_distance"]);
  EXPECT_THAT(said_, HasSubstr("at most 600 faces and at most 200 faces as levels of detail"));
}

TEST_F(DecimatedFit, SaysWhereSeamsLeaveMore) {
  write("c.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
        "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  const json report = report_of("fit c.obj -o c.ply --faces 2");
  EXPECT_EQ(report["outputs"][0]["triangles"], 12);
  EXPECT_EQ(report["warnings"][0]["code"], "triangles-not-reached");
  EXPECT_EQ(report["exit_code"], 0);
}

TEST_F(DecimatedFit, ScenesChoose) {
  write("scene.json", R"({"version": 1, "jobs": [{"input": "torus.obj", "report": "r.json",
    "faces": [90], "outputs": [{"path": "a.glb"}, {"path": "b.glb", "levels": [1]},
    {"path": "c.glb", "pixels": "1@100"}, {"path": "d.glb", "edge_lengths": [0.5]}]}]})");
  run("run scene.json");
  expect_values(read_json("r.json")["outputs"], {{"/0/triangles", 90},
                                                 {"/1/level", 1},
                                                 {"/2/decimated/distance", 0.01},
                                                 {"/3/decimated/edge_length", 0.5}});
}

// A promise as a tolerance is: what is written is flagged.
TEST_F(AdaptiveFit, AnglesThatCannotBeKeptEndWithFive) {
  // A sheet that is folded onto itself.
  write("t.obj",
        "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 0.5 0 0\nv 0.5 1 0\n"
        "f 1 2 5 4\nf 2 7 8 5\n");
  const json report =
      report_of("fit t.obj -o a.ply --angle 5 --interpolation progressive --creases use", 5);
  EXPECT_TRUE(exists("a.ply"));
  EXPECT_EQ(report["exit_code"], 5);
  const json& warnings = report["warnings"];
  EXPECT_TRUE(std::ranges::any_of(warnings, [](const json& warning) {
    return warning["code"] == "angle-not-kept";
  })) << warnings;
  EXPECT_THAT(said_, AllOf(HasSubstr("an angle of 5 degrees is not kept beneath "),
                           HasSubstr("near ("), HasSubstr("allow a larger angle")));
}

// Whose faces turn by more than 64 times the angle: triangles are as small as that takes. At the
// tips of vertices of other valence, which may be folds, they end at 2^-7 of half an edge.
TEST_F(AdaptiveFit, SmallAnglesAreKept) {
  write("t.obj", "v 1 1 1\nv -1 -1 1\nv -1 1 -1\nv 1 -1 -1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  for (const std::string angle : {"1.1", "20"})
    EXPECT_THAT(report_of("fit t.obj -o a.ply --angle " + angle)["warnings"], IsEmpty());
}

}  // namespace
}  // namespace planish::test
