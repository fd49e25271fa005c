#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cli/json_schema.h"
#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/asset_sample.h"
#include "planish/files/mesh_file.h"
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
  ProcessResult fit(const std::string& input, std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", input, "--device", "cpu", "-f"});
    return run_planish(flags);
  }

  AssetSample sample_;
  std::string input_ = write("asset.glb", sample_.glb());
};

TEST_F(AssetCommand, WritesWhatTheLibraryDoes) {
  const ProcessResult result = fit(input_, {"-o", path("out.glb"), "--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(
      result.err,
      AllOf(
          HasSubstr("asset.glb: 3 meshes, "),
          HasSubstr("surfaces    3 fair; 3 with triangles joined to quads; normals off by up to "),
          Not(HasSubstr("warning"))));
  const json report = read_json("r.json");
  const json schema = json::parse(std::ifstream(PLANISH_REPORT_SCHEMA));
  EXPECT_THAT(schema_problems(report, schema), testing::IsEmpty());
  ASSERT_EQ(report["meshes"].size(), 3U);
  EXPECT_EQ(report["meshes"][0]["asset"]["name"], "tube");
  EXPECT_LT(report["meshes"][0]["asset"]["lost_joint_weight"], 0.05);
  EXPECT_EQ(report["outputs"][0]["bytes"], read("out.glb").size());
  // On stdout the same bytes.
  EXPECT_EQ(fit(input_, {"-o", "-"}).out, read("out.glb"));
}

// With formats that hold one mesh the scene becomes one, and that is said.
TEST_F(AssetCommand, BesideOtherFormatsTheSceneIsMerged) {
  const ProcessResult both = fit(input_, {"-o", path("out.glb"), "-o", path("out.obj")});
  ASSERT_EQ(both.exit_code, 0) << both.err;
  EXPECT_THAT(both.err, AllOf(HasSubstr("the scene becomes one mesh"), HasSubstr("out.obj")));
  EXPECT_FALSE(document_of(read("out.glb")).contains("skins"));
  const ProcessResult merged = fit(input_, {"-o", path("out.glb"), "--asset", "merge"});
  ASSERT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_THAT(merged.err, Not(HasSubstr("the scene becomes one mesh")));
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
  const ProcessResult result =
      fit(write("flat.glb", sample_.glb()), {"-o", path("out.glb"), "--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("meshes[2] stays as it is"));
  EXPECT_EQ(document_of(read("out.glb"))["meshes"][2], given);
  EXPECT_EQ(read_json("r.json")["warnings"][0]["code"], "kept-mesh");
}

// Nodes of compressed meshes that nobody moves get a child with the grid; others keep float32.
// Materials go with the one mesh, each by itself where the file gives them no names of their own.
TEST_F(AssetCommand, AMergedSceneKeepsItsMaterials) {
  json& materials = sample_.json["materials"];
  materials[0].erase("name");
  materials[1]["name"] = materials[2]["name"];
  materials[1]["occlusionTexture"] = {{"index", 0}, {"texCoord", 1}};
  const std::string input = write("asset.glb", sample_.glb());
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
  for (const char* packing : {"none", "meshopt"}) {
    const ProcessResult result =
        fit(input, {"-o", path("out.glb"), "--asset", "merge", "--compress", packing});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, HasSubstr("textures of further sets of texture coordinates"));
    const std::string glb = read("out.glb");
    const json made = document_of(glb), view = compare(made);
    EXPECT_EQ(view["buffer"], 0);
    const std::size_t buffer = glb.find("BIN") + 4;
    EXPECT_EQ(glb.substr(buffer + view["byteOffset"].get<std::size_t>(), view["byteLength"]),
              AssetSample::image());
    EXPECT_EQ(made["buffers"][0]["byteLength"], glb.size() - buffer);
    EXPECT_THAT(made["extensionsUsed"].dump(), HasSubstr("KHR_materials_clearcoat"));
  }
  ASSERT_EQ(fit(input, {"-o", path("out.gltf"), "--asset", "merge"}).exit_code, 0);
  const json view = compare(read_json("out.gltf"));
  EXPECT_EQ(read("out.bin").substr(view["byteOffset"], view["byteLength"]), AssetSample::image());
}

// As often as EXT_mesh_gpu_instancing places them, turned and scaled; required or not.
TEST_F(AssetCommand, AMergedSceneHasAllInstances) {
  json& node = sample_.json["nodes"][7];
  node["rotation"] = {0, 0, 1, 0};  // half a turn: x and y change their sign
  sample_.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  const std::string input = write("asset.glb", sample_.glb());
  ASSERT_EQ(fit(input, {"-o", path("out.obj"), "--levels", "0"}).exit_code, 0);
  const PolygonMesh mesh = read_mesh(path("out.obj")).mesh;
  for (const double x : {0.0, -3.0, -6.0}) {
    const auto is_pole = [&](const glm::dvec3& p) {
      return glm::length(p - glm::dvec3(x, 1, 0)) < 1e-5;
    };
    EXPECT_EQ(std::ranges::count_if(mesh.positions, is_pole), 1) << x;
  }
  const ProcessResult seen = run_planish({"inspect", input});
  EXPECT_EQ(seen.exit_code, 0) << seen.err;
  // One scale too few.
  const int places = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"];
  json shorter = sample_.json["accessors"][places];
  shorter["count"] = 2;
  sample_.json["accessors"].push_back(shorter);
  node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] =
      sample_.json["accessors"].size() - 1;
  const ProcessResult refused =
      fit(write("asset.glb", sample_.glb()), {"-o", path("out.obj"), "-f"});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("nodes[7].extensions.EXT_mesh_gpu_instancing"),
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
  const std::string input = write("asset.glb", sample_.glb());
  const ProcessResult result = fit(input, {"-o", path("out.glb"), "--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::vector<std::string> lines;
  std::istringstream all(result.err);
  for (std::string line; std::getline(all, line);)
    if (line.find("warning: ") != std::string::npos) lines.push_back(line);
  ASSERT_EQ(lines.size(), 1u) << result.err;
  EXPECT_EQ(lines[0], "planish: warning: " + input +
                          ": 3 meshes, first copy 0: 1 triangle without area was left out");
  const json report = read_json("r.json");
  for (int copy = 0; copy < 3; ++copy)
    EXPECT_EQ(report["meshes"][3 + copy]["warnings"].size(), 1u) << copy;
}

// A missing image keeps nobody from the shape.
TEST_F(AssetCommand, MissingImagesOfAMergedSceneAreAWarning) {
  const std::string input = write("asset.gltf", sample_.gltf("asset.bin", "none.png"));
  write("asset.bin", sample_.bytes);
  const ProcessResult result = fit(input, {"-o", path("out.glb"), "--asset", "merge"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, AllOf(HasSubstr("none.png"), HasSubstr("materials are as without it")));
}

TEST_F(AssetCommand, CompressedNodesKeepTheirPlaces) {
  const ProcessResult result = fit(input_, {"-o", path("out.glb"), "--compress", "meshopt",
                                            "--tolerance", "1e-4", "--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_LE(read_json("r.json")["outputs"][0]["as_written_error"].get<double>(), 1e-4);
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
  const std::string input = write("asset.glb", sample_.glb());
  const json seen = json::parse(run_planish({"inspect", input, "--json"}).out);
  const json schema = json::parse(std::ifstream(PLANISH_REPORT_SCHEMA));
  EXPECT_THAT(schema_problems(seen, schema), testing::IsEmpty());
  const ProcessResult result = fit(input, {"-o", path("out.glb")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("triangles that give way: EXT_mesh_manifold"));
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
  EXPECT_THAT(run_planish({"inspect", input}).out,
              AllOf(HasSubstr("3 meshes, 3 materials, 1 texture, 1 image"), HasSubstr("left out"),
                    Not(HasSubstr("ignored"))));
}

TEST_F(AssetCommand, ADryRunCountsAllMeshes) {
  const ProcessResult dry = fit(input_, {"-o", path("out.glb"), "--dry-run"});
  ASSERT_EQ(dry.exit_code, 0) << dry.err;
  EXPECT_THAT(dry.out, HasSubstr("asset.glb: 3 meshes, "));
  EXPECT_THAT(dry.out, testing::ContainsRegex("out.glb  \\(level ., .* vertices, .* quads\\)"));
}

TEST_F(AssetCommand, LevelsAreAssetsToo) {
  const ProcessResult result = fit(input_, {"-o", path("out.glb"), "--levels", "2,0"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* name : {"out_LOD0.glb", "out_LOD1.glb"})
    EXPECT_EQ(document_of(read(name))["skins"], sample_.json["skins"]) << name;
}

// Triangles as fine as the surface bends, and other schemes, carry the same.
TEST_F(AssetCommand, AnyFinenessCarriesWhatRides) {
  for (const std::vector<std::string>& how :
       {std::vector<std::string>{"--chord-error", "1e-3"}, {"--scheme", "catmull-clark"}}) {
    std::vector<std::string> flags{"-o", path("out.glb")};
    flags.insert(flags.end(), how.begin(), how.end());
    const ProcessResult result = fit(input_, flags);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, Not(HasSubstr("left out")));
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
  const ProcessResult result = fit(input_, {"-o", path("out.glb"), "--levels", "0,2,1", "--lods",
                                            "msft", "--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json report = read_json("r.json");
  const json schema = json::parse(std::ifstream(PLANISH_REPORT_SCHEMA));
  EXPECT_THAT(schema_problems(report, schema), testing::IsEmpty());
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

TEST_F(AssetCommand, LevelsOfDetailThatCannotBeAreRefused) {
  const std::vector<std::string> lods{"--levels", "2,1", "--lods", "msft", "-o"};
  const auto refusal = [&](const std::string& input, std::vector<std::string> more) {
    std::vector<std::string> flags = lods;
    flags.insert(flags.end(), more.begin(), more.end());
    const ProcessResult result = fit(input, flags);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    return result.err;
  };
  EXPECT_THAT(refusal(write("cube.obj", cube_obj()), {path("a.glb")}),
              HasSubstr("take --lods files"));
  EXPECT_THAT(refusal(input_, {path("a.glb"), "--asset", "merge"}), HasSubstr("--asset keep"));
  EXPECT_THAT(refusal(input_, {path("a.ply")}), HasSubstr("are of glTF alone"));
  sample_.json["nodes"][4]["extensions"]["MSFT_lod"]["ids"] = {5};
  EXPECT_THAT(refusal(write("lod.glb", sample_.glb()), {path("a.glb")}),
              HasSubstr("nodes[4] has levels of detail already"));
  EXPECT_FALSE(exists("a.glb"));
}

// Joints that each move few corners of a cube of quads, by Catmull-Clark: B is singular there.
TEST_F(AssetCommand, WhatNoSurfacePassesThroughIsRefused) {
  const PolygonMesh cube = test::cube();
  const ProcessResult result =
      fit(write("cube.glb", large_asset({cube}, {{.joints = 8}})),
          {"-o", path("out.glb"), "--scheme", "catmull-clark", "--quads", "on"});
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_THAT(result.err, AllOf(HasSubstr("mesh0: "), HasSubstr("--scheme doo-sabin")));
  EXPECT_FALSE(exists("out.glb"));
}

// What becomes of the things in an asset, one by one: our column of the table in
// files/gltf/asset/measurements.md.

struct Check {
  std::string what, wanted;
  std::function<std::string()> made;
};

struct Glb {
  explicit Glb(std::string file) : bytes(std::move(file)), document(document_of(bytes)) {}

  // Of an accessor that lies in a view without gaps.
  [[nodiscard]] std::string bytes_of(const json& accessor) const {
    const json& view =
        document["bufferViews"][document["accessors"][accessor.get<std::size_t>()]["bufferView"]
                                    .get<std::size_t>()];
    return view_bytes(view);
  }
  [[nodiscard]] std::string view_bytes(const json& view) const {
    return bytes.substr(bytes.find("BIN\0", 0, 4) + 4 + view.value("byteOffset", std::size_t{0}),
                        view["byteLength"].get<std::size_t>());
  }
  [[nodiscard]] std::int64_t count_of(const json& accessor) const {
    return document["accessors"][accessor.get<std::size_t>()]["count"];
  }

  std::string bytes;
  json document;
};

TEST_F(FolderTest, AnAssetKeepsWhatItHas) {
  AssetSample sample;
  const std::string input = write("asset.glb", sample.glb());
  const ProcessResult result =
      run_planish({"fit", input, "-o", path("out.glb"), "--device", "cpu"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Glb from(read("asset.glb")), to(read("out.glb"));
  const json &given = from.document, &made = to.document;
  const auto same = [](bool is_same) { return std::string(is_same ? "=" : "changed"); };
  // Attributes of the first primitive of a mesh, one for each vertex of its surface.
  const auto carried = [&](std::size_t mesh, std::initializer_list<const char*> names) {
    const json& attributes = made["meshes"][mesh]["primitives"][0]["attributes"];
    const std::int64_t rows = to.count_of(attributes["POSITION"]);
    for (const char* name : names)
      if (!attributes.contains(name) || to.count_of(attributes[name]) != rows ||
          rows <= from.count_of(given["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"]))
        return std::string("not on the surface: ") + name;
    return std::string("on the surface");
  };
  const auto same_accessors = [&](const json& a, const json& b) {
    return from.bytes_of(a) == to.bytes_of(b);
  };
  const auto key_frames = [&] {
    bool is_same = made["animations"] == given["animations"];
    for (const json& sampler : given["animations"][0]["samplers"])
      for (const char* key : {"input", "output"})
        is_same = is_same && same_accessors(sampler[key], sampler[key]);
    return same(is_same);
  };
  const auto line = [&] {
    const json &a = given["meshes"][2]["primitives"][1], &b = made["meshes"][2]["primitives"][1];
    return same(a == b && same_accessors(a["attributes"]["POSITION"], b["attributes"]["POSITION"]));
  };
  const auto mesh_names = [&] {
    bool is_same = true;
    for (std::size_t m = 0; m < given["meshes"].size(); ++m)
      is_same = is_same && made["meshes"][m]["name"] == given["meshes"][m]["name"];
    return same(is_same);
  };
  const auto images = [&] {
    const auto bytes = [](const Glb& of) {
      return of.view_bytes(
          of.document["bufferViews"][of.document["images"][0]["bufferView"].get<std::size_t>()]);
    };
    return made["materials"] == given["materials"] && made["textures"] == given["textures"] &&
           bytes(from) == bytes(to);
  };
  const std::vector<Check> checks{
      {"copyright, asset.extras", "=",
       [&] {
         return same(made["asset"]["copyright"] == "me" &&
                     made["asset"]["extras"]["pipeline"] == 7);
       }},
      {"nodes, names, order", "=", [&] { return same(made["nodes"] == given["nodes"]); }},
      {"extras of nodes and primitives", "=",
       [&] {
         return same(made["nodes"][4]["extras"] == given["nodes"][4]["extras"] &&
                     made["meshes"][2]["primitives"][0]["extras"] ==
                         given["meshes"][2]["primitives"][0]["extras"]);
       }},
      {"materials, KHR_materials_clearcoat, image bytes", "=", [&] { return same(images()); }},
      {"samplers", "=", [&] { return same(made["samplers"] == given["samplers"]); }},
      {"an extension that nobody knows", "=",
       [&] {
         return same(made["extensions"]["VENDOR_secret"] == given["extensions"]["VENDOR_secret"]);
       }},
      {"TEXCOORD_0, TEXCOORD_1", "on the surface",
       [&] {
         return carried(0, {"TEXCOORD_0", "TEXCOORD_1"});
       }},
      {"COLOR_0, numbers of one's own", "on the surface",
       [&] {
         return carried(1, {"COLOR_0", "_HEAT"});
       }},
      {"skin: joints, inverse bind matrices", "=",
       [&] {
         const json &a = given["skins"], &b = made["skins"];
         return same(a == b &&
                     same_accessors(a[0]["inverseBindMatrices"], b[0]["inverseBindMatrices"]));
       }},
      {"JOINTS_0, WEIGHTS_0", "on the surface",
       [&] {
         return carried(0, {"JOINTS_0", "WEIGHTS_0"});
       }},
      {"morph targets, their names", "on the surface, with normals",
       [&] {
         const json& mesh = made["meshes"][0];
         const bool has_names = mesh["extras"] == given["meshes"][0]["extras"];
         const json& target = mesh["primitives"][0]["targets"][0];
         const bool is_carried =
             has_names && to.count_of(target["POSITION"]) ==
                              to.count_of(mesh["primitives"][0]["attributes"]["POSITION"]);
         return is_carried && target.contains("NORMAL")
                    ? std::string("on the surface, with normals")
                    : std::string("changed");
       }},
      {"animation: key frames", "=", key_frames},
      {"lights, instancing", "=",
       [&] {
         const json& places = given["nodes"][7]["extensions"]["EXT_mesh_gpu_instancing"]
                                   ["attributes"]["TRANSLATION"];
         return same(made["extensions"]["KHR_lights_punctual"] ==
                         given["extensions"]["KHR_lights_punctual"] &&
                     made["nodes"][7] == given["nodes"][7] && same_accessors(places, places));
       }},
      {"line primitive", "=", line},
      {"names of meshes", "=", mesh_names},
  };
  for (const Check& check : checks) EXPECT_EQ(check.made(), check.wanted) << check.what;
}

}  // namespace
}  // namespace planish::test
