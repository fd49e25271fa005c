#include <gmock/gmock.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <set>
#include <string>
#include <vector>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/asset_sample.h"
#include "planish/files/mesh_file.h"
#include "planish/job/fit_file.h"
#include "support/calls.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

// What the command does with a glTF of several meshes; what comes out is tested in tests/pipeline.

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class AssetCommand : public FolderTest {
 protected:
  // Fits the sample as it is by now.
  json fit(const std::string& flags, int exit_code = 0) {
    write("asset.glb", sample_.glb());
    return report_of("fit asset.glb " + flags, exit_code);
  }

  AssetSample sample_;
};

TEST_F(AssetCommand, WritesWhatTheLibraryDoes) {
  const json report = fit("-o out.glb");
  EXPECT_THAT(
      said_,
      AllOf(
          HasSubstr("asset.glb: 3 meshes, "),
          HasSubstr("surfaces    3 fair; 3 with triangles joined to quads; normals off by up to "),
          Not(HasSubstr("warning"))));
  ASSERT_EQ(report["meshes"].size(), 3U);
  EXPECT_EQ(report["meshes"][0]["asset"]["name"], "tube");
  EXPECT_LT(report["meshes"][0]["asset"]["lost_joint_weight"], 0.05);
  EXPECT_EQ(report["outputs"][0]["bytes"], read("out.glb").size());
  EXPECT_EQ(run("fit asset.glb -o -").out, read("out.glb"));
  (void)fit_file(path("asset.glb"), path("library.glb"));
  EXPECT_EQ(read("library.glb"), read("out.glb"));
}

// With formats that hold one mesh the scene becomes one, and that is said.
TEST_F(AssetCommand, BesideOtherFormatsTheSceneIsMerged) {
  fit("-o out.glb -o out.obj");
  EXPECT_THAT(said_, AllOf(HasSubstr("the scene becomes one mesh"), HasSubstr("out.obj")));
  EXPECT_FALSE(document_of(read("out.glb")).contains("skins"));
  fit("-o out.glb --asset merge");
  EXPECT_THAT(said_, Not(HasSubstr("the scene becomes one mesh")));
  EXPECT_EQ(document_of(read("out.glb"))["meshes"].size(), 1U);
}

TEST_F(AssetCommand, WhatHasNoSurfaceStays) {
  // Triangles that name a vertex twice: the joints' numbers, taken for vertices.
  const int joints = sample_.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"];
  sample_.json["accessors"].push_back(
      {{"bufferView", sample_.json["accessors"][joints]["bufferView"]},
       {"componentType", 5121},
       {"count", 12},
       {"type", "SCALAR"}});
  sample_.json["meshes"][2]["primitives"][0]["indices"] = sample_.json["accessors"].size() - 1;
  const json given = sample_.json["meshes"][2];
  const json report = fit("-o out.glb");
  EXPECT_THAT(said_, HasSubstr("meshes[2] stays as it is"));
  EXPECT_EQ(document_of(read("out.glb"))["meshes"][2], given);
  EXPECT_EQ(report["warnings"][0]["code"], "kept-mesh");
}

// Materials go with the one mesh, each by itself where the file gives them no names of their own.
TEST_F(AssetCommand, AMergedSceneKeepsItsMaterials) {
  json& materials = sample_.json["materials"];
  materials[0].erase("name");
  materials[1]["name"] = materials[2]["name"];
  materials[1]["occlusionTexture"] = {{"index", 0}, {"texCoord", 1}};
  const auto compare = [&](const json& made) {
    json wanted = sample_.json["materials"];
    wanted[0]["name"] = "material_0";
    wanted[1].erase("occlusionTexture");
    wanted[2]["name"] = "plain_2";
    EXPECT_EQ(made["materials"], wanted);
    EXPECT_EQ(made["textures"], sample_.json["textures"]);
    EXPECT_EQ(made["samplers"], sample_.json["samplers"]);
    EXPECT_EQ(made["meshes"].size(), 1U);
    EXPECT_EQ(made["meshes"][0]["primitives"].size(), 3U);
    return made["bufferViews"][made["images"][0]["bufferView"].get<std::size_t>()];
  };
  for (const std::string packing : {"none", "meshopt"}) {
    fit("-o out.glb --asset merge --compress " + packing);
    EXPECT_THAT(said_, HasSubstr("textures of further sets of texture coordinates"));
    const std::string glb = read("out.glb");
    const json made = document_of(glb), view = compare(made);
    EXPECT_EQ(view["buffer"], 0);
    const std::size_t buffer = glb.find("BIN") + 4;
    EXPECT_EQ(glb.substr(buffer + view["byteOffset"].get<std::size_t>(), view["byteLength"]),
              AssetSample::image());
    EXPECT_EQ(made["buffers"][0]["byteLength"], glb.size() - buffer);
    EXPECT_THAT(made["extensionsUsed"].dump(), HasSubstr("KHR_materials_clearcoat"));
  }
  fit("-o out.gltf --asset merge");
  const json view = compare(read_json("out.gltf"));
  EXPECT_EQ(read("out.bin").substr(view["byteOffset"], view["byteLength"]), AssetSample::image());
}

// As often as EXT_mesh_gpu_instancing places them, turned and scaled; required or not.
TEST_F(AssetCommand, AMergedSceneHasAllInstances) {
  json& node = sample_.json["nodes"][7];
  node["rotation"] = {0, 0, 1, 0};  // half a turn: x and y change their sign
  sample_.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  fit("-o out.obj --levels 0");
  const PolygonMesh mesh = read_mesh(path("out.obj")).mesh;
  for (const double x : {0.0, -3.0, -6.0}) {
    const auto is_pole = [&](const glm::dvec3& p) {
      return glm::length(p - glm::dvec3(x, 1, 0)) < 1e-5;
    };
    EXPECT_EQ(std::ranges::count_if(mesh.positions, is_pole), 1) << x;
  }
  run("inspect asset.glb");
  // One scale too few.
  const int places = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"];
  json shorter = sample_.json["accessors"][places];
  shorter["count"] = 2;
  sample_.json["accessors"].push_back(shorter);
  node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] =
      sample_.json["accessors"].size() - 1;
  write("short.glb", sample_.glb());
  run("fit short.glb -o short.obj", 3);
  EXPECT_THAT(said_, AllOf(HasSubstr("nodes[7].extensions.EXT_mesh_gpu_instancing"),
                           HasSubstr("another attribute has 2")));
}

// What many meshes are warned of is one line with the first of them, and the path once.
TEST_F(AssetCommand, WarningsOfMeshesAreOneLineAKind) {
  json& meshes = sample_.json["meshes"];
  const json ball = meshes[1];
  for (int copy = 0; copy < 3; ++copy) {
    json& mesh = meshes.emplace_back(ball);
    mesh["name"] = "copy " + std::to_string(copy);
    // As many triangles without area besides.
    json indices = sample_.json["accessors"][ball["primitives"][0]["indices"].get<std::size_t>()];
    const json view = sample_.json["bufferViews"][indices["bufferView"].get<std::size_t>()];
    const std::string given = sample_.bytes.substr(view["byteOffset"].get<std::size_t>(),
                                                   view["byteLength"].get<std::size_t>());
    const std::string further(std::size_t{6} * (copy + 1), '\0');
    sample_.bytes.resize((sample_.bytes.size() + 3) / 4 * 4, '\0');
    sample_.json["bufferViews"].push_back({{"buffer", 0},
                                           {"byteOffset", sample_.bytes.size()},
                                           {"byteLength", given.size() + further.size()}});
    sample_.bytes += given + further;
    indices["bufferView"] = sample_.json["bufferViews"].size() - 1;
    indices["count"] = indices["count"].get<int>() + 3 * (copy + 1);
    sample_.json["accessors"].push_back(indices);
    mesh["primitives"][0]["indices"] = sample_.json["accessors"].size() - 1;
    sample_.json["scenes"][0]["nodes"].push_back(sample_.json["nodes"].size());
    sample_.json["nodes"].push_back({{"mesh", meshes.size() - 1}});
  }
  const json report = fit("-o out.glb");
  std::vector<std::string> warnings = lines_of(said_);
  std::erase_if(warnings, [](const std::string& line) { return !line.starts_with("planish: "); });
  EXPECT_THAT(warnings, testing::ElementsAre("planish: warning: asset.glb: 3 meshes, first copy 0: "
                                             "1 triangle without area was left out"));
  for (int copy = 0; copy < 3; ++copy)
    EXPECT_EQ(report["meshes"][3 + copy]["warnings"].size(), 1u) << copy;
}

// A missing image keeps nobody from the shape.
TEST_F(AssetCommand, MissingImagesOfAMergedSceneAreAWarning) {
  write("asset.gltf", sample_.gltf("asset.bin", "none.png"));
  write("asset.bin", sample_.bytes);
  run("fit asset.gltf -o out.glb --asset merge");
  EXPECT_THAT(said_, AllOf(HasSubstr("none.png"), HasSubstr("materials are as without it")));
}

// Nodes of compressed meshes that nobody moves get a child with the grid; others keep float32.
TEST_F(AssetCommand, CompressedNodesKeepTheirPlaces) {
  const json report = fit("-o out.glb --compress meshopt --tolerance 1e-4");
  EXPECT_LE(report["outputs"][0]["as_written_error"].get<double>(), 1e-4);
  const json made = document_of(read("out.glb"));
  EXPECT_EQ(made["nodes"][0]["mesh"], 0);  // skinned
  EXPECT_EQ(made["nodes"][7]["mesh"], 2);  // instanced
  EXPECT_FALSE(made["nodes"][4].contains("mesh"));
  const json child = made["nodes"][made["nodes"][4]["children"][0].get<int>()];
  EXPECT_EQ(child["mesh"], 1);
  EXPECT_TRUE(child.contains("scale"));
  EXPECT_EQ(made["nodes"][4]["translation"], sample_.json["nodes"][4]["translation"]);
}

// What inspect says of an asset is what fit writes.
TEST_F(AssetCommand, InspectSaysWhatPasses) {
  auto& attributes = sample_.json["meshes"][1]["primitives"][0]["attributes"];
  const auto vertices = sample_.json["accessors"][attributes["POSITION"].get<int>()]["count"];
  sample_.json["accessors"].push_back(
      {{"bufferView", 0}, {"componentType", 5121}, {"count", vertices}, {"type", "SCALAR"}});
  attributes["_FEATURE_ID_0"] = sample_.json["accessors"].size() - 1;
  sample_.json["meshes"][1]["extensions"]["EXT_mesh_manifold"]["mergeIndices"]["accessor"] = 0;
  sample_.json["extensionsUsed"].push_back("EXT_mesh_manifold");
  fit("-o out.glb");
  EXPECT_THAT(said_, HasSubstr("triangles that give way: EXT_mesh_manifold"));
  const json seen = printed("inspect asset.glb --json");
  EXPECT_THAT(report_problems(seen), testing::IsEmpty());
  EXPECT_EQ(seen["asset"]["left_out"], json::array({"EXT_mesh_manifold"}));
  const json made = document_of(read("out.glb"));
  for (const auto& [list, count] : seen["asset"]["counts"].items())
    EXPECT_EQ(made[list].size(), count) << list;
  std::set<std::string> written;
  std::size_t targets = 0;
  for (const json& mesh : made["meshes"]) {
    targets += mesh["primitives"][0].contains("targets") ? 1 : 0;
    for (const json& primitive : mesh["primitives"])
      for (const auto& [name, accessor] : primitive["attributes"].items()) written.insert(name);
  }
  written.erase("NORMAL");  // which the surface has of its own
  EXPECT_EQ(json(written), seen["asset"]["carried"]);
  EXPECT_EQ(targets, seen["asset"]["morph_targets"]);
  for (const json& name : seen["asset"]["extensions"])
    EXPECT_TRUE(std::ranges::find(made["extensionsUsed"], name) != made["extensionsUsed"].end());
  EXPECT_THAT(run("inspect asset.glb").out,
              AllOf(HasSubstr("3 meshes, 3 materials, 1 texture, 1 image"), HasSubstr("left out"),
                    Not(HasSubstr("ignored"))));
}

TEST_F(AssetCommand, ADryRunCountsAllMeshes) {
  write("asset.glb", sample_.glb());
  EXPECT_THAT(run("fit asset.glb -o out.glb --dry-run").out,
              AllOf(HasSubstr("asset.glb: 3 meshes, "),
                    testing::ContainsRegex("out.glb  \\(level ., .* vertices, .* quads\\)")));
}

TEST_F(AssetCommand, LevelsAreAssetsToo) {
  fit("-o out.glb --levels 2,0");
  for (const char* name : {"out_LOD0.glb", "out_LOD1.glb"})
    EXPECT_EQ(document_of(read(name))["skins"], sample_.json["skins"]) << name;
}

// Triangles as fine as the surface bends, and other schemes, carry the same.
TEST_F(AssetCommand, AnyFinenessCarriesWhatRides) {
  for (const char* how : {"--chord-error 1e-3", "--scheme catmull-clark"}) {
    fit(std::string("-o out.glb ") + how);
    EXPECT_THAT(said_, Not(HasSubstr("left out")));
    const json made = document_of(read("out.glb"));
    const json& tube = made["meshes"][0]["primitives"][0];
    const auto vertices = made["accessors"][tube["attributes"]["POSITION"].get<int>()]["count"];
    for (const char* name : {"TEXCOORD_1", "JOINTS_0", "WEIGHTS_0", "TANGENT"})
      EXPECT_EQ(made["accessors"][tube["attributes"][name].get<int>()]["count"], vertices) << name;
    EXPECT_TRUE(tube["targets"][0].contains("NORMAL"));
    EXPECT_TRUE(made["meshes"][1]["primitives"][0]["attributes"].contains("_HEAT"));
  }
}

// Each level has the meshes with their materials, skins and targets, in the nodes' places.
TEST_F(AssetCommand, LevelsOfDetailInOneFile) {
  const json report = fit("-o out.glb --levels 0,2,1 --lods msft");
  EXPECT_EQ(report["outputs"][0]["coarser"], json::parse(R"([{"level":1},{"level":0}])"));
  const json made = document_of(read("out.glb"));
  ASSERT_EQ(made["meshes"].size(), 9U);
  const auto triangles = [&](std::size_t mesh) {
    std::int64_t count = 0;
    for (const json& primitive : made["meshes"][mesh]["primitives"])
      if (primitive.value("mode", 4) == 4)
        count += made["accessors"][primitive["indices"].get<int>()]["count"].get<std::int64_t>();
    return count;
  };
  const auto details = [&](const json& node) {
    std::vector<std::size_t> meshes{node["mesh"]};
    for (const json& id : node["extensions"]["MSFT_lod"]["ids"])
      meshes.push_back(made["nodes"][id.get<int>()]["mesh"]);
    EXPECT_EQ(node["extras"]["MSFT_screencoverage"], json::parse("[0.25,0.0625,0.0]"));
    return meshes;
  };
  // Of a skinned node they stand beside it, with the skin; weights of all of them move.
  const json& body = made["nodes"][0];
  const std::vector<std::size_t> bodies = details(body);
  ASSERT_EQ(bodies.size(), 3U);
  std::set<std::size_t> moved;
  for (const json& channel : made["animations"][0]["channels"])
    if (channel["target"]["path"] == "weights")
      moved.insert(channel["target"]["node"].get<std::size_t>());
  EXPECT_EQ(moved.size(), 3U);
  for (const json& id : body["extensions"]["MSFT_lod"]["ids"]) {
    const json& node = made["nodes"][id.get<int>()];
    EXPECT_EQ(node["skin"], 0);
    EXPECT_TRUE(moved.contains(id.get<std::size_t>()));
    const json& part = made["meshes"][node["mesh"].get<int>()]["primitives"][0];
    EXPECT_EQ(part["material"], 0);
    EXPECT_EQ(part["targets"].size(), 1U);
    for (const char* name : {"JOINTS_0", "TEXCOORD_1", "TANGENT"})
      EXPECT_TRUE(part["attributes"].contains(name)) << name;
  }
  for (std::size_t k = 1; k < 3; ++k) EXPECT_LT(triangles(bodies[k]), triangles(bodies[k - 1]));
  // Of another node they are children, so that it moves all of them; lines are in each.
  EXPECT_FALSE(made["nodes"][7].contains("mesh"));
  const json& many = made["nodes"][made["nodes"][7]["children"][0].get<int>()];
  EXPECT_TRUE(many["extensions"].contains("EXT_mesh_gpu_instancing"));
  for (const std::size_t mesh : details(many)) {
    EXPECT_EQ(made["meshes"][mesh]["primitives"].size(), 2U);
    EXPECT_EQ(made["meshes"][mesh]["primitives"][0]["extras"]["id"], 4);
  }
  EXPECT_EQ(made["nodes"][4]["translation"], sample_.json["nodes"][4]["translation"]);
  EXPECT_THAT(made["extensionsUsed"].dump(), HasSubstr("MSFT_lod"));
  EXPECT_FALSE(made.contains("extensionsRequired")) << made["extensionsRequired"];
}

// Joints that each move few corners of a cube of quads, by Catmull-Clark: B is singular there.
TEST_F(AssetCommand, WhatNoSurfacePassesThroughIsRefused) {
  write("cube.glb", large_asset({test::cube()}, {{.joints = 8}}));
  run("fit cube.glb -o out.glb --scheme catmull-clark --quads on", 2);
  EXPECT_THAT(said_, AllOf(HasSubstr("mesh0: "), HasSubstr("--scheme doo-sabin")));
  EXPECT_FALSE(exists("out.glb"));
}

// The quads of each mesh: level 1 has a quarter of those of level 2.
class PartSettings : public AssetCommand {
 protected:
  // By mesh, the options that held for it.
  static std::vector<json> held(const json& report) {
    std::vector<json> all;
    for (const json& mesh : report["meshes"]) {
      all.emplace_back(json::object());
      if (mesh["asset"].contains("set"))
        for (const json& one : mesh["asset"]["set"]) all.back()[one["option"]] = one["value"];
    }
    return all;
  }
  // To quads.
  static bool is_joined(const json& mesh) {
    return mesh["input"]["faces"].get<int>() < mesh["input"]["file_faces"].get<int>();
  }
};

TEST_F(PartSettings, HoldForMeshesMaterialsAndNodes) {
  const std::string base = "--quads off --interpolation progressive --levels 2 ";
  const json plain = fit("-o plain.glb " + base);
  const json report = fit("-o out.glb --force " + base +
                          "--set mesh=ball:levels=1 --set material=check:interpolation=fair "
                          "--set node=m*y:quads=on;node=nobody*:creases=ignore");
  EXPECT_THAT(held(report), testing::ElementsAre(json{{"interpolation", "fair"}},
                                                 json{{"levels", "1"}}, json{{"quads", "on"}}));
  EXPECT_EQ(held(plain), std::vector<json>(3, json::object()));
  for (int mesh = 0; mesh < 3; ++mesh) {
    const json& choice = report["meshes"][mesh]["solve"];
    EXPECT_EQ(choice["method"], mesh == 0 ? "fair" : "progressive") << mesh;
    EXPECT_EQ(plain["meshes"][mesh]["solve"]["method"], "progressive");
    EXPECT_EQ(is_joined(report["meshes"][mesh]), mesh == 2) << mesh;
  }
  EXPECT_THAT(said_, AllOf(HasSubstr("set         mesh=ball: levels 1 for 1 mesh"),
                           HasSubstr("node=nobody*: creases ignore for 0 meshes")));
  const auto rows = [&](const char* name, int mesh) {
    const json document = document_of(read(name));
    const int number =
        document["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"].get<int>();
    return document["accessors"][number]["count"].get<int>();
  };
  EXPECT_EQ(rows("out.glb", 0), rows("plain.glb", 0));
  EXPECT_LT(3 * rows("out.glb", 1), rows("plain.glb", 1));
}

// All of a mesh's own triangles: those of the material, and others beside them.
TEST_F(PartSettings, LaterOnesCountAndScenesHaveThem) {
  write("asset.glb", sample_.glb());
  write("s.json", R"({"version": 1, "jobs": [{"input": "asset.glb", "report": "r.json",
    "outputs": [{"path": "o.glb"}], "quads": "off",
    "set": "material=red:quads=on; mesh=many:quads=off"}]})");
  run("run s.json");
  const json report = read_json("r.json");
  EXPECT_EQ(held(report)[0], (json{{"quads", "on"}}));
  EXPECT_EQ(held(report)[2], (json{{"quads", "off"}}));
  EXPECT_EQ(report["meshes"][0]["warnings"][0]["code"], "set-for-all-materials");
  EXPECT_THAT(said_, HasSubstr("tube: material=red: quads holds for all of the mesh, which has 2 "
                               "materials"));
  EXPECT_TRUE(is_joined(report["meshes"][0]));
  EXPECT_FALSE(is_joined(report["meshes"][2]));
}

TEST_F(PartSettings, NamesThatAreNoneAreRefused) {
  write("asset.glb", sample_.glb());
  write("box.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
  const auto said = [&](const std::string& flags) {
    const ProcessResult result = run("fit " + flags + " -f", 2);
    return result.out + result.err;
  };
  EXPECT_THAT(said("asset.glb -o o.glb --set mesh=bal:quads=on"),
              HasSubstr("mesh=bal: asset.glb has no mesh of that name; did you mean ball?; there "
                        "are ball, tube, many"));
  EXPECT_THAT(said("asset.glb -o o.glb --set material=ball:quads=on --dry-run"),
              HasSubstr("material=ball: asset.glb has no material of that name; there are check, "
                        "red, plain"));
  EXPECT_THAT(said("asset.glb -o o.glb --set node=low:quads=on"),
              HasSubstr("there are body, ball, half, many"));
  EXPECT_THAT(said("asset.glb -o o.glb --set ball:quads=on"),
              HasSubstr("--set: \"ball:quads=on\": mesh=NAME:OPTION=VALUE is wanted"));
  EXPECT_THAT(said("asset.glb -o o.glb --set mesh=ball:quad=on"),
              HasSubstr("parts have no \"quad\" of their own; did you mean quads?; they may have"));
  EXPECT_THAT(said("asset.glb -o o.glb --set mesh=ball:scheme=loop"), HasSubstr("\"scheme\""));
  EXPECT_THAT(said("asset.glb -o o.glb --set mesh=ball:quads=maybe"),
              HasSubstr("\"maybe\" is not one of"));
  EXPECT_THAT(said("asset.glb -o o.glb --set mesh=ball:levels=1,2"), HasSubstr("one level"));
  EXPECT_THAT(said("asset.glb -o o.glb --levels 2,1 --set mesh=ball:levels=1"),
              HasSubstr("where all outputs have one level"));
  EXPECT_THAT(said("asset.glb -o o.glb --scheme loop --set mesh=ball:interpolation=fair"),
              HasSubstr("fair builds control points"));
  EXPECT_THAT(said("box.obj -o o.glb --set mesh=ball:quads=on"),
              HasSubstr("mesh=ball: box.obj becomes one mesh"));
  EXPECT_FALSE(exists("o.glb"));
}

}  // namespace
}  // namespace planish::test
