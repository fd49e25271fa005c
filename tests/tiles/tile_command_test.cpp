// Sets of tiles as the command writes them.
#include <gmock/gmock.h>
#include <signal.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "cli/json_schema.h"
#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/asset_sample.h"
#include "files/gltf/glb_bytes.h"
#include "support/file_size_limit.h"
#include "support/files_below.h"
#include "tiles/read_tiles.h"

namespace planish::test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class TileCommand : public FolderTest {
 protected:
  ProcessResult fit(std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", torus_, "--device", "cpu"});
    return run_planish(flags);
  }
  ProcessResult fit_set(std::vector<std::string> flags = {}) {
    flags.insert(flags.end(), {"-o", path("t.json"), "--tile-vertices", "1000"});
    return fit(std::move(flags));
  }

  std::string torus_ = write("torus.obj", torus_obj(32));
};

TEST_F(TileCommand, WritesASetAndReportsIt) {
  const ProcessResult result = fit_set({"--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(names(), ElementsAre("r.json", "t", "t.json", "torus.obj"));
  const nlohmann::json report = read_json("r.json");
  std::ifstream file(PLANISH_REPORT_SCHEMA);
  EXPECT_THAT(schema_problems(report, nlohmann::json::parse(file)), IsEmpty());
  const nlohmann::json output = report["outputs"][0];
  EXPECT_EQ(output["level"], 2);
  EXPECT_EQ(output["vertices"], 16 * 32 * 32);
  EXPECT_EQ(output["quads"], 16 * 32 * 32);
  EXPECT_LT(output["as_written_error"], 1e-6);
  EXPECT_GT(output["as_written_error"], 0);
  const ReadTileset set = read_tileset(path("t.json"));
  std::vector<std::int64_t> tiles(3), bytes(3), triangles(3);
  for (const ReadTile& tile : set.tiles) {
    if (tile.content.empty()) continue;
    ++tiles[tile.level];
    bytes[tile.level] += static_cast<std::int64_t>(fs::file_size(tile.content));
    triangles[tile.level] += triangles_of(tile).face_count();
  }
  std::int64_t all = static_cast<std::int64_t>(read("t.json").size());
  ASSERT_EQ(output["tiles"].size(), 2u);
  for (int level = 1; level <= 2; ++level) {
    const nlohmann::json& at = output["tiles"][level - 1];
    EXPECT_EQ(at["level"], level);
    EXPECT_EQ(at["tiles"], tiles[level]);
    EXPECT_EQ(at["bytes"], bytes[level]);
    EXPECT_EQ(at["triangles"], triangles[level]);
    all += bytes[level];
  }
  EXPECT_EQ(output["bytes"], all);
  EXPECT_GT(tiles[2], tiles[1]);
  EXPECT_GT(output["tiles"][0]["geometric_error"], 0);
  EXPECT_EQ(output["tiles"][1]["geometric_error"], 0);
  EXPECT_THAT(result.err + result.out, HasSubstr("tiles, to level 2"));
}

TEST_F(TileCommand, FairSurfacesAndAxesToo) {
  ASSERT_EQ(fit_set({"--interpolation", "fair"}).exit_code, 0);
  const PolygonMesh y_up = welded(read_tileset(path("t.json")), 2);
  EXPECT_EQ(y_up.vertex_count(), 16 * 32 * 32);
  // Of a model with Z up, tiles have its own axes.
  ASSERT_EQ(fit_set({"--interpolation", "fair", "--up", "z", "-f"}).exit_code, 0);
  const PolygonMesh z_up = welded(read_tileset(path("t.json")), 2);
  ASSERT_EQ(z_up.vertex_count(), y_up.vertex_count());
  for (std::int32_t v = 0; v < z_up.vertex_count(); ++v) {
    const glm::dvec3 p = z_up.positions[v];
    ASSERT_EQ(y_up.positions[v], glm::dvec3(p.x, -p.z, p.y));
  }
}

TEST_F(TileCommand, ScenesHaveTheSameSettings) {
  write("s.json", R"({"version": 1, "jobs": [{"input": "torus.obj", "tile_vertices": 1000,
    "skirts": true, "device": "cpu", "outputs": [{"path": "a.json"}]}]})");
  const ProcessResult result = run_planish({"run", path("s.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  ASSERT_EQ(fit({"-o", path("b.json"), "--tile-vertices", "1000", "--skirts"}).exit_code, 0);
  EXPECT_EQ(files_below(path("a")), files_below(path("b")));
  ASSERT_EQ(fit_set().exit_code, 0);
  EXPECT_NE(files_below(path("a")), files_below(path("t"))) << "skirts are more";
}

// Each tile has the materials of its faces; images stand once beside all of them.
TEST_F(TileCommand, TilesHaveTheMaterialsOfAnAsset) {
  AssetSample sample;
  const std::string input = write("asset.glb", sample.glb());
  for (int turn = 0; turn < 2; ++turn) {
    const ProcessResult result = run_planish(
        {"fit", input, "--device", "cpu", "-f", "-o", path("t.json"), "--tile-vertices", "256"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  EXPECT_EQ(read("t/images/0.png"), AssetSample::image());
  std::set<std::string> seen;
  for (const ReadTile& tile : read_tileset(path("t.json")).tiles) {
    if (tile.content.empty()) continue;
    const nlohmann::json made = document_of(read(tile.content.string()));
    for (const nlohmann::json& material : made["materials"]) {
      const auto given = std::ranges::find(sample.json["materials"], material);
      ASSERT_NE(given, sample.json["materials"].end()) << material;
      seen.insert(material["name"]);
    }
    EXPECT_EQ(made["images"][0]["uri"], "../images/0.png");
    EXPECT_EQ(made["textures"], sample.json["textures"]);
  }
  EXPECT_EQ(seen, (std::set<std::string>{"check", "red", "plain"}));
  // A stranger's file in that folder stays.
  write("t/images/mine.txt", "");
  EXPECT_EQ(run_planish({"fit", input, "-f", "-o", path("t.json")}).exit_code, 7);
}

TEST_F(TileCommand, FlagsWithoutTilesAreToldToHaveNoEffect) {
  const ProcessResult result = fit({"-o", path("t.glb"), "--skirts", "--tile-vertices", "1000"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("without effect here: --tile-vertices, --skirts"));
  EXPECT_THAT(result.err, HasSubstr("no output 3D Tiles)"));
  EXPECT_THAT(fit_set({"--skirts"}).err, Not(HasSubstr("without effect")));
}

TEST_F(TileCommand, RefusesByName) {
  const auto error = [&](std::vector<std::string> flags) {
    const ProcessResult result = fit_set(std::move(flags));
    EXPECT_EQ(result.exit_code, 2);
    return result.err;
  };
  EXPECT_THAT(error({"--scheme", "catmull-clark"}),
              HasSubstr("3D Tiles are made of Doo-Sabin surfaces, not of catmull-clark"));
  EXPECT_THAT(error({"--levels", "0"}), HasSubstr("3D Tiles have levels from 1 on, not 0"));
  EXPECT_THAT(error({"--attributes", "error"}), HasSubstr("t.json cannot hold them"));
  EXPECT_THAT(fit({"-o", path("t.json"), "--tile-vertices", "255"}).err,
              HasSubstr("--tile-vertices: 255 is out of range; 256 to 16777216"));
  EXPECT_THAT(names(), ElementsAre("torus.obj"));
}

TEST_F(TileCommand, ForceReplacesASetAndNothingElse) {
  ASSERT_EQ(fit_set({"--levels", "3"}).exit_code, 0);
  const auto old = files_below(path("t"));
  const std::string document = read("t.json");
  const ProcessResult refused = fit_set();
  EXPECT_EQ(refused.exit_code, 7);
  EXPECT_THAT(refused.err, HasSubstr("t.json exists; --force overwrites it"));
  fs::remove(path("t.json"));
  EXPECT_THAT(fit_set().err, HasSubstr("exists; --force replaces it"));
  EXPECT_EQ(files_below(path("t")), old);
  write("t.json", document);
  // A file of somebody else's, in the folder and in one of its own.
  for (const char* foreign : {"t/readme.txt", "t/0/picture.glb"}) {
    write(foreign, "mine");
    const ProcessResult kept = fit_set({"-f"});
    EXPECT_EQ(kept.exit_code, 7) << foreign;
    EXPECT_THAT(kept.err, HasSubstr(foreign));
    EXPECT_EQ(read(foreign), "mine");
    EXPECT_EQ(read("t.json"), document);
    fs::remove(path(foreign));
  }
  EXPECT_EQ(files_below(path("t")), old);
  ASSERT_EQ(fit_set({"-f"}).exit_code, 0);
  EXPECT_LT(files_below(path("t")).size(), old.size());
  EXPECT_EQ(welded(read_tileset(path("t.json")), 2).vertex_count(), 16 * 32 * 32);
  EXPECT_THAT(names(), ElementsAre("t", "t.json", "torus.obj"));
}

TEST_F(TileCommand, TheFolderIsNoPlaceForOtherOutputs) {
  fs::create_directory(path("t"));
  const ProcessResult result = fit({"-o", path("t/a.glb"), "-o", path("t.json")});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("the folder of the tiles, has"));
  const ProcessResult reversed = fit({"-o", path("t.json"), "-o", path("t/a.glb")});
  EXPECT_EQ(reversed.exit_code, 2);
  EXPECT_THAT(reversed.err, HasSubstr("t/a.glb lies in the folder of tiles"));
}

TEST_F(TileCommand, FullDisksAndInterruptsLeaveTheOldSet) {
  ASSERT_EQ(fit_set().exit_code, 0);
  const auto old = files_below(path("t"));
  const std::string document = read("t.json");
  const auto expect_old = [&] {
    EXPECT_EQ(files_below(path("t")), old);
    EXPECT_EQ(read("t.json"), document);
    EXPECT_THAT(names(), ElementsAre("t", "t.json", "torus.obj"));
  };
  {
    const ProcessResult result = [&] {
      const FileSizeLimit limit(16 << 10);
      return fit({"-o", path("t.json"), "-f", "--levels", "3"});
    }();
    EXPECT_EQ(result.exit_code, 7) << result.err;
    EXPECT_THAT(result.err, HasSubstr("cannot write"));
    expect_old();
  }
  PlanishProcess process({"fit", torus_, "--device", "cpu", "-o", path("t.json"), "-f", "--levels",
                          "6", "--progress", "json"},
                         {});
  EXPECT_TRUE(process.wait_for_message("\"write\""));
  ::kill(process.id(), SIGINT);
  EXPECT_EQ(process.finish().exit_code, 130);
  expect_old();
}

}  // namespace
}  // namespace planish::test
