// What the command does with --bake; what the maps show is tested in tests/pipeline.
#include <gmock/gmock.h>

#include <fstream>
#include <set>
#include <string>

#include "cli/json_schema.h"
#include "cli/needs.h"
#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/asset_sample.h"

namespace planish::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// A plate whose texture coordinates are its x and y.
std::string mapped_plate(double stretch = 1, int side = 4) {
  std::string lines = "usemtl bark\n";
  for (int j = 0; j <= side; ++j)
    for (int i = 0; i <= side; ++i) {
      const double x = double(i) / side, y = double(j) / side;
      lines += "v " + std::to_string(x) + " " + std::to_string(y) + " " +
               std::to_string(0.4 * x * (1 - x)) + "\nvt " + std::to_string(stretch * x) + " " +
               std::to_string(stretch * y) + "\n";
    }
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      lines += "f";
      for (const int k : {0, 1, side + 2, side + 1}) {
        const std::string number = std::to_string(j * (side + 1) + i + k + 1);
        lines += " " + number + "/" + number;
      }
      lines += "\n";
    }
  return lines;
}

class BakeCommand : public FolderTest {
 protected:
  ProcessResult fit(const std::string& input, std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", input, "--device", "cpu", "-f"});
    return run_planish(flags);
  }

  std::string plate_ = write("plate.obj", mapped_plate());
};

TEST_F(BakeCommand, WritesTheMeshItselfWithItsMap) {
  const ProcessResult result =
      fit(plate_, {"-o", path("p.glb"), "--bake", "64", "--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json report = read_json("r.json");
  EXPECT_THAT(schema_problems(report, json::parse(std::ifstream(PLANISH_REPORT_SCHEMA))),
              IsEmpty());
  const json& output = report["outputs"][0];
  EXPECT_EQ(output["level"], 0);
  EXPECT_EQ(output["vertices"], 25);
  EXPECT_EQ(output["bake"]["size"], 64);
  ASSERT_EQ(output["bake"]["maps"].size(), 1U);
  const json& map = output["bake"]["maps"][0];
  EXPECT_EQ(map["material"], "bark");
  EXPECT_NEAR(map["covered"].get<double>(), 1, 1e-9);
  EXPECT_EQ(map["overlapped"], 0);
  const json document = document_of(read("p.glb"));
  EXPECT_EQ(document["images"][0]["mimeType"], "image/png");
  EXPECT_TRUE(document["meshes"][0]["primitives"][0]["attributes"].contains("TANGENT"));
  EXPECT_EQ(document["materials"][0]["normalTexture"]["index"], 0);
  EXPECT_EQ(map["bytes"], document["bufferViews"].back()["byteLength"]);
  // The same on stdout, and in a .gltf whose buffer has the image.
  EXPECT_EQ(fit(plate_, {"-o", "-", "--bake", "64"}).out, read("p.glb"));
  ASSERT_EQ(fit(plate_, {"-o", path("q.gltf"), "--bake", "64"}).exit_code, 0);
  EXPECT_EQ(json::parse(read("q.gltf"))["images"], document["images"]);
  EXPECT_THAT(names(), ElementsAre("p.glb", "plate.obj", "q.bin", "q.gltf", "r.json"));
}

TEST_F(BakeCommand, ScenesDoTheSame) {
  ASSERT_EQ(fit(plate_, {"-o", path("p.glb"), "--bake", "64"}).exit_code, 0);
  write("scene.json", R"({"version": 1, "jobs": [{"input": "plate.obj", "bake": 64,
                          "device": "cpu", "outputs": [{"path": "s.glb"}]}]})");
  const ProcessResult result = run_planish({"run", path("scene.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read("s.glb"), read("p.glb"));
}

TEST_F(BakeCommand, RefusesWhatHoldsNoMap) {
  const auto refusal = [&](std::vector<std::string> flags) {
    const ProcessResult result = fit(plate_, std::move(flags));
    EXPECT_EQ(result.exit_code, 2);
    return result.err;
  };
  for (const std::string name : {"p.stl", "p.obj", "p.ply", "p.step", "p.usda", "tiles.json"})
    EXPECT_THAT(refusal({"-o", path(name), "--bake", "64"}),
                HasSubstr(name + " holds no baked map; .glb and .gltf do"));
  EXPECT_THAT(refusal({"-o", path("p.glb"), "--bake", "15"}), HasSubstr("--bake: 15"));
  EXPECT_THAT(refusal({"-o", path("p.glb"), "--bake", "8193"}),
              AllOf(HasSubstr("--bake: 8193"), HasSubstr("16 to 8192")));
  EXPECT_THAT(refusal({"-o", path("p.glb"), "--bake", "64", "--levels", "2"}),
              HasSubstr("p.glb: a baked map is of level 0, the input's own mesh"));
  EXPECT_THAT(refusal({"-o", path("p.glb"), "--bake", "64", "--levels", "1,0"}),
              HasSubstr("a baked map is of level 0"));
  EXPECT_THAT(refusal({"-o", path("p.glb"), "--bake", "64", "--chord-error", "0.01"}),
              HasSubstr("a baked map is of level 0"));
  EXPECT_THAT(refusal({"-o", path("p.glb"), "--bake", "64", "--refine", "on"}),
              HasSubstr("--refine: a baked map is of the input's own vertices"));
  EXPECT_THAT(refusal({"--report", path("r.json"), "--bake", "64"}),
              HasSubstr("--bake: no surface is written that holds a map"));
  EXPECT_THAT(names(), ElementsAre("plate.obj"));
}

TEST_F(BakeCommand, RefusesMeshesThatNoMapFits) {
  const auto refusal = [&](const std::string& name, const std::string& obj) {
    const ProcessResult result = fit(write(name, obj), {"-o", path("p.glb"), "--bake", "64"});
    EXPECT_EQ(result.exit_code, 4);
    return result.err;
  };
  EXPECT_THAT(refusal("bare.obj", bumpy_plate_obj(4)),
              HasSubstr("bare.obj: has no texture coordinates, by which a map is baked; unwrap"));
  EXPECT_THAT(refusal("tiled.obj", mapped_plate(3)),
              AllOf(HasSubstr("tiled.obj: material `bark`: its texture repeats (face "),
                    HasSubstr("unwrap the mesh into the square from 0 to 1")));
  EXPECT_FALSE(exists("p.glb"));
}

TEST_F(BakeCommand, GivesEachMeshOfAnAssetItsMaps) {
  AssetSample sample;
  const ProcessResult result =
      fit(write("asset.glb", sample.glb()),
          {"-o", path("a.glb"), "--bake", "64", "--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, AllOf(HasSubstr("2 meshes, first ball: has no texture coordinates"),
                                HasSubstr("it stays without a map")));
  const json report = read_json("r.json");
  EXPECT_THAT(schema_problems(report, json::parse(std::ifstream(PLANISH_REPORT_SCHEMA))),
              IsEmpty());
  const json& maps = report["outputs"][0]["bake"]["maps"];
  ASSERT_EQ(maps.size(), 2U);
  EXPECT_EQ(maps[0]["mesh"], "tube");
  EXPECT_EQ(maps[0]["material"], "check");
  EXPECT_EQ(maps[1]["material"], "red");
  EXPECT_NEAR(maps[1]["covered"].get<double>(), 0.5, 1e-6);
  const json given = sample.json, made = document_of(read("a.glb"));
  for (const char* kept : {"nodes", "skins", "animations", "cameras", "scenes"})
    EXPECT_EQ(made[kept].size(), given[kept].size()) << kept;
  const json& primitives = made["meshes"][0]["primitives"];
  for (const json& primitive : primitives) {
    for (const char* name : {"TANGENT", "JOINTS_0", "WEIGHTS_0", "TEXCOORD_1"})
      EXPECT_TRUE(primitive["attributes"].contains(name)) << name;
    EXPECT_EQ(primitive["targets"].size(), 1U);
  }
  // The red material is also that of a mesh without coordinates, which keeps it as it is.
  EXPECT_EQ(primitives[0]["material"], 0);
  EXPECT_EQ(primitives[1]["material"], 3);
  EXPECT_EQ(made["meshes"][2]["primitives"][0]["material"], 1);
  EXPECT_EQ(made["materials"][1], given["materials"][1]);
  EXPECT_EQ(made["materials"][3]["name"], "red");
  // The clear coat of the other one has no normals of its own.
  EXPECT_EQ(
      made["materials"][0]["normalTexture"],
      made["materials"][0]["extensions"]["KHR_materials_clearcoat"]["clearcoatNormalTexture"]);
  EXPECT_EQ(made["images"].size(), 3U);
}

TEST_F(BakeCommand, LiesByTheSetThatTheNormalTextureNames) {
  AssetSample sample;
  sample.json["materials"][0]["normalTexture"] = {{"index", 0}, {"texCoord", 1}, {"scale", 0.5}};
  ASSERT_EQ(fit(write("asset.glb", sample.glb()),
                {"-o", path("a.glb"), "--bake", "64", "--report", path("r.json")})
                .exit_code,
            0);
  const json document = document_of(read("a.glb"));
  // Its scale is in the map.
  EXPECT_EQ(document["materials"][0]["normalTexture"], (json{{"index", 1}, {"texCoord", 1}}));
  // That set has half the width and height.
  const json maps = read_json("r.json")["outputs"][0]["bake"]["maps"];
  EXPECT_NEAR(maps[0]["covered"].get<double>(), 0.125, 1e-6);
  EXPECT_NEAR(maps[1]["covered"].get<double>(), 0.5, 1e-6);
}

TEST_F(BakeCommand, VariantsOfMaterialsAreTold) {
  AssetSample sample;
  sample.json["extensionsUsed"].push_back("KHR_materials_variants");
  sample.json["extensions"]["KHR_materials_variants"] = {
      {"variants", {{{"name", "a"}}, {{"name", "b"}}}}};
  sample.json["meshes"][0]["primitives"][1]["extensions"]["KHR_materials_variants"] = {
      {"mappings", {{{"material", 1}, {"variants", {0}}}, {{"material", 2}, {"variants", {1}}}}}};
  const ProcessResult result =
      fit(write("asset.glb", sample.glb()), {"-o", path("a.glb"), "--bake", "64"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("variants of materials keep the normal textures"));
  const json primitive = document_of(read("a.glb"))["meshes"][0]["primitives"][1];
  EXPECT_EQ(primitive["material"], 3);
  const json& mappings = primitive["extensions"]["KHR_materials_variants"]["mappings"];
  EXPECT_EQ(mappings[0]["material"], 3);
  EXPECT_EQ(mappings[1]["material"], 2);
}

// Two meshes of one material: each has a copy of its own, the last one the material itself.
TEST_F(BakeCommand, MeshesShareNoMap) {
  AssetSample sample;
  sample.json["meshes"].push_back(sample.json["meshes"][0]);
  sample.json["nodes"].push_back({{"mesh", 3}, {"skin", 0}});
  sample.json["scenes"][0]["nodes"].push_back(9);
  ASSERT_EQ(fit(write("asset.glb", sample.glb()), {"-o", path("a.glb"), "--bake", "64"}).exit_code,
            0);
  const json document = document_of(read("a.glb"));
  std::set<int> materials, images;
  for (const int mesh : {0, 3})
    for (const json& primitive : document["meshes"][mesh]["primitives"]) {
      const int material = primitive["material"];
      materials.insert(material);
      const int texture = document["materials"][material]["normalTexture"]["index"];
      images.insert(document["textures"][texture]["source"].get<int>());
    }
  EXPECT_EQ(materials.size(), 4U);
  EXPECT_EQ(images.size(), 4U);
}

TEST_F(BakeCommand, RefusesAssetsWithoutCoordinates) {
  AssetSample sample;
  for (json& primitive : sample.json["meshes"][0]["primitives"]) {
    primitive["attributes"].erase("TEXCOORD_0");
    primitive["attributes"].erase("TEXCOORD_1");
  }
  const ProcessResult result =
      fit(write("asset.glb", sample.glb()), {"-o", path("a.glb"), "--bake", "64"});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("tube: has no texture coordinates"));
  EXPECT_FALSE(exists("a.glb"));
}

TEST_F(BakeCommand, CompressionKeepsTangents) {
  for (const std::string mode : {"quantize", "meshopt"}) {
    ASSERT_EQ(fit(plate_, {"-o", path("p.glb"), "--bake", "64", "--compress", mode}).exit_code, 0);
    const json document = document_of(read("p.glb"));
    EXPECT_TRUE(document["meshes"][0]["primitives"][0]["attributes"].contains("TANGENT")) << mode;
    EXPECT_EQ(document["images"].size(), 1U);
  }
}

// A texture that repeats on one material leaves the map of another alone.
TEST_F(BakeCommand, LeavesOutWhatRepeats) {
  const ProcessResult result =
      fit(write("two.obj", mapped_plate() +
                               "usemtl brick\nv 3 0 0\nv 4 0 0\nv 4 1 0\nv 3 1 0\n"
                               "vt 0 0\nvt 3 0\nvt 3 3\nvt 0 3\nf -4/-4 -3/-3 -2/-2 -1/-1\n"),
          {"-o", path("p.glb"), "--bake", "64", "--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("two.obj: material `brick`: its texture repeats (face 16, "));
  const json maps = read_json("r.json")["outputs"][0]["bake"]["maps"];
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_EQ(maps[0]["material"], "bark");
}

TEST_F(Needs, OfBakedMapsAreKnown) {
  write("plate.obj", mapped_plate(1, 40));
  for (const char* size : {"64", "2048"})
    expect_enough({"plate.obj", "-o", "p.glb", "--bake", size});
  // A page holds where the texture is.
  write("large.obj", mapped_plate(1, 120));
  expect_enough({"large.obj", "--page", "p.html"});
  // Nobody knows how well a map packs.
  const std::string text = fit({"plate.obj", "-o", "q.glb", "--bake", "64", "--dry-run"}).out;
  EXPECT_THAT(text, HasSubstr("q.glb  (level 0, 1,681 vertices, 1,600 faces)"));
}

}  // namespace
}  // namespace planish::test
