#include <gmock/gmock.h>

#include <cstring>
#include <set>
#include <string>

#include "cli/needs.h"
#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/asset_sample.h"

namespace planish::test {
namespace {

// What files bring along and get beside them: normals, materials, axes.

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

using Formats = FolderTest;

// A box of a flat normal on each side, and the same smooth.
std::string box_obj(bool is_flat) {
  std::string text;
  for (int i = 0; i < 8; ++i)
    text += "v " + std::to_string(i & 1) + " " + std::to_string(i >> 1 & 1) + " " +
            std::to_string(i >> 2) + "\n";
  text += "vn 0 0 -1\nvn 0 0 1\nvn 0 -1 0\nvn 0 1 0\nvn -1 0 0\nvn 1 0 0\n";
  int side = 0;
  for (const char* face : {"1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"}) {
    ++side;
    text += "usemtl " + std::string(side < 3 ? "lid" : "wall") + "\nf";
    for (const char* c = face; *c != '\0'; c += c[1] == '\0' ? 1 : 2)
      text += std::string(" ") + *c + (is_flat ? "//" + std::to_string(side) : "");
    text += "\n";
  }
  return text;
}

TEST_F(Formats, SplitNormalsAreCreases) {
  write("flat.obj", box_obj(true));
  write("smooth.obj", box_obj(false));
  const json report =
      report_of("fit flat.obj --creases normals --cage cage.obj --levels 1 -o a.ply");
  expect_values(report, {{"/solve/creases", "normals"}, {"/input/sharp_edges", 12}});
  EXPECT_THAT(read("cage.obj"), HasSubstr("planish creases=normals"));
  // The cage names the rule, so that the input is read by it again.
  run("verify cage.obj flat.obj");
  run("verify cage.obj flat.obj --creases ignore", 5);
  const json smooth = report_of("fit smooth.obj --creases normals --cage b.obj -o b.ply");
  EXPECT_EQ(smooth["warnings"][0]["code"], "no-split-normals");
  EXPECT_THAT(said_, HasSubstr("smooth.obj: --creases normals found no edge where normals"));
}

TEST_F(Formats, MaterialsOfObjLieBesideIt) {
  write("in/box.obj", box_obj(false));
  run("fit in/box.obj -o a.obj --cage c.obj --levels 0");
  EXPECT_THAT(read("a.obj"), HasSubstr("mtllib a.mtl\n"));
  EXPECT_THAT(read("c.obj"), HasSubstr("mtllib c.mtl\n"));
  EXPECT_THAT(read("a.mtl"), HasSubstr("newmtl lid\nKd "));
  EXPECT_THAT(read("c.mtl"), HasSubstr("newmtl wall\nKd "));
  write("d.mtl", "old");
  run("fit in/box.obj -o d.obj --levels 0 -f");
  EXPECT_THAT(read("d.mtl"), HasSubstr("newmtl lid"));
  // Nothing is written where there is no material.
  write("e.mtl", "precious");
  write("plain.obj", bumpy_plate_obj(4));
  run("fit plain.obj -o e.obj -f");
  EXPECT_EQ(read("e.mtl"), "precious");
  EXPECT_THAT(read("e.obj"), Not(HasSubstr("mtllib")));
}

TEST_F(Formats, UsdSaysWhichAxisIsUp) {
  write("plate.obj", bumpy_plate_obj(4));
  run("fit plate.obj -o y.usda --up y --levels 0");
  run("fit plate.obj -o z.usda --up z --levels 0");
  const std::string y = read("y.usda"), z = read("z.usda");
  EXPECT_THAT(y, HasSubstr("upAxis = \"Y\""));
  EXPECT_THAT(z, HasSubstr("upAxis = \"Z\""));
  // Turned by its reader, not by us.
  EXPECT_EQ(y.substr(y.find("def Xform")), z.substr(z.find("def Xform")));
}

// As they stand in the input's own file, textures named from where the output stands; a material
// that nobody knows gets a colour.
TEST_F(Formats, MaterialsOfAnObjComeAlong) {
  write("out/keep", "");
  write("model/box.obj", "mtllib box.mtl\nmtllib gone.mtl\n" + box_obj(false));
  write("model/box.mtl",
        "# of hand\nnewmtl lid\nKd 0.1 0.2 0.3\nmap_Kd -s 2 2 1 -clamp on textures/my lid.png\n"
        "bump -bm 0.5 /abs/bump.png\nnewmtl unused\nKd 1 1 1\n");
  run("fit model/box.obj -o out/a.obj --cage out/c.obj --levels 1");
  EXPECT_THAT(said_, AllOf(HasSubstr("its materials are not there: "), HasSubstr("gone.mtl"),
                           Not(HasSubstr("box.mtl"))));
  const std::string materials = read("out/a.mtl");
  EXPECT_EQ(read("out/c.mtl"), materials);
  EXPECT_THAT(materials, HasSubstr("newmtl lid\nKd 0.1 0.2 0.3\n"
                                   "map_Kd -s 2 2 1 -clamp on ../model/textures/my lid.png\n"
                                   "bump -bm 0.5 /abs/bump.png\n"));
  EXPECT_THAT(materials, AllOf(HasSubstr("newmtl wall\nKd "), Not(HasSubstr("unused"))));
  // In the same folder every line stays as it is.
  run("fit model/box.obj -o model/a.obj --levels 1");
  EXPECT_THAT(read("model/a.mtl"), HasSubstr("map_Kd -s 2 2 1 -clamp on textures/my lid.png\n"));
  // Those of a cage alone, too.
  run("fit model/box.obj --cage model/c.obj");
  EXPECT_EQ(read("model/c.mtl"), read("model/a.mtl"));
  // Where no OBJ is written nobody misses them.
  run("fit model/box.obj -o out/a.ply");
  EXPECT_THAT(said_, Not(HasSubstr("materials are not")));
}

class Attributes : public FolderTest {
 protected:
  std::string plate_ = write("plate.obj", bumpy_plate_obj(6));
};

// The scalars of an attribute of a GLB.
std::vector<float> scalars(const std::string& glb, const std::string& name) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  const auto document = nlohmann::json::parse(glb.substr(20, length));
  const auto& accessor =
      document["accessors"][document["meshes"][0]["primitives"][0]["attributes"][name].get<int>()];
  const auto& view = document["bufferViews"][accessor["bufferView"].get<int>()];
  std::vector<float> values(accessor["count"].get<std::size_t>());
  std::memcpy(values.data(), glb.data() + 28 + length + view["byteOffset"].get<std::size_t>(),
              4 * values.size());
  return values;
}

TEST_F(Attributes, ErrorsInTheFileAreTheReports) {
  const json report =
      report_of("fit plate.obj -o p.glb --attributes error,deviation --interpolation progressive");
  const auto errors = scalars(read("p.glb"), "_ERROR");
  const auto deviations = scalars(read("p.glb"), "_DEVIATION");
  const auto worst = std::ranges::max_element(errors);
  EXPECT_NEAR(*worst, report["solve"]["error"]["max"].get<double>(), 1e-9);
  EXPECT_EQ(worst - errors.begin(), report["solve"]["error"]["worst_vertex"]);
  EXPECT_NEAR(std::ranges::max(deviations), report["surface"]["max_normal_deviation"].get<double>(),
              1e-4);
  EXPECT_THAT(read("p.glb"), Not(HasSubstr("_FOLD")));
  run("fit plate.obj -o f.glb --attributes fold");
  for (const float share : scalars(read("f.glb"), "_FOLD")) EXPECT_EQ(share, 0.0f);
}

// A figure that is asked for has its name before a property of the input.
TEST_F(Attributes, PropertiesOfTheInputAreCarried) {
  write("cube.ply",
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
        "property float z\nproperty float Quality\nproperty float Error\nelement face 6\n"
        "property list uchar int vertex_indices\nend_header\n"
        "0 0 0 1 9\n1 0 0 2 9\n1 1 0 3 9\n0 1 0 4 9\n0 0 1 5 9\n1 0 1 6 9\n1 1 1 7 9\n"
        "0 1 1 8 9\n"
        "4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n");
  run("fit cube.ply -o p.glb -o p.ply --attributes error --levels 1 --creases use");
  EXPECT_THAT(said_, HasSubstr("properties of the vertices are left out: Error; fields"));
  const std::vector<float> values = scalars(read("p.glb"), "_QUALITY");
  ASSERT_EQ(values.size(), 26u);
  EXPECT_THAT(std::vector(values.begin(), values.begin() + 8), ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(std::vector(values.begin() + 8, values.end()),
              testing::Each(AllOf(testing::Gt(1), testing::Lt(8))));
  EXPECT_LT(std::ranges::max(scalars(read("p.glb"), "_ERROR")), 1);
  EXPECT_THAT(read("p.ply"), HasSubstr("property float error\nproperty float Quality\n"));
}

TEST_F(Attributes, CurvatureSaysWhatItIsTakenFrom) {
  run("fit plate.obj -o p.glb -o p.ply --attributes curvature");
  EXPECT_EQ(scalars(read("p.glb"), "_GAUSSIAN_CURVATURE").size(), 625u);
  EXPECT_THAT(read("p.glb"), HasSubstr(R"("curvature_from":"second derivatives")"));
  EXPECT_THAT(read("p.ply"), HasSubstr("comment planish curvature_from=second derivatives\n"));
  EXPECT_THAT(read("p.ply"),
              HasSubstr("property float mean_curvature\nproperty float gaussian_curvature\n"));
}

class Compress : public FolderTest {
 protected:
  std::string plate_ = write("plate.obj", bumpy_plate_obj(6));
};

TEST_F(Compress, WrittenErrorsStayWithinTheTolerance) {
  double last = 0;
  for (const std::string mode : {"none", "quantize", "meshopt"}) {
    for (const std::string tolerance : {"1e-4", "1e-6"}) {
      const std::string line =
          "fit plate.obj -o p.glb --compress " + mode + " --tolerance " + tolerance;
      SCOPED_TRACE(line);
      const json output = report_of(line)["outputs"][0];
      EXPECT_LE(output["as_written_error"].get<double>(), std::stod(tolerance));
      const double bytes = output["bytes"].get<double>();
      EXPECT_EQ(bytes, read("p.glb").size());
      if (tolerance == "1e-4") continue;
      if (mode != "none") {
        EXPECT_LT(bytes, last);
      }
      last = bytes;
    }
  }
}

// 16 bits move positions by some 1e-5 of the diagonal, of which the default tolerance leaves less.
TEST_F(Compress, QuantizeSaysWherePositionsStayFloat) {
  run("fit plate.obj -o p.glb --compress quantize");
  EXPECT_THAT(said_,
              AllOf(HasSubstr("p.glb: positions stay 32 bits: 16 would move them by up to 9"),
                    HasSubstr("e-06 of the diagonal, and --tolerance leaves ")));
  for (const char* flags : {"quantize --tolerance 1e-3", "meshopt"}) {
    run(std::string("fit plate.obj -f -o p.glb --compress ") + flags);
    EXPECT_THAT(said_, Not(HasSubstr("positions stay")));
  }
}

TEST_F(Compress, StdoutIsCompressedToo) {
  run("fit plate.obj -o p.glb --compress meshopt");
  const std::string piped = run("fit plate.obj -o - --compress meshopt").out;
  EXPECT_EQ(piped.size(), read("p.glb").size());
  EXPECT_THAT(piped, HasSubstr("EXT_meshopt_compression"));
}

// What the command does with --bake; what the maps show is tested in tests/pipeline.

// A plate whose texture coordinates are its x and y.
std::string mapped_plate(int side = 4) {
  std::string lines = "usemtl bark\n";
  for (int j = 0; j <= side; ++j)
    for (int i = 0; i <= side; ++i) {
      const double x = double(i) / side, y = double(j) / side;
      lines += "v " + std::to_string(x) + " " + std::to_string(y) + " " +
               std::to_string(0.4 * x * (1 - x)) + "\nvt " + std::to_string(x) + " " +
               std::to_string(y) + "\n";
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
  // The report of a fit of the sample as it is by now, whose document it leaves in made_.
  json bake_sample() {
    write("asset.glb", sample_.glb());
    json report = report_of("fit asset.glb -o a.glb --bake 64");
    made_ = document_of(read("a.glb"));
    return report;
  }

  std::string plate_ = write("plate.obj", mapped_plate());
  AssetSample sample_;
  json made_;
};

TEST_F(BakeCommand, WritesTheMeshItselfWithItsMap) {
  const json output = report_of("fit plate.obj -o p.glb --bake 64")["outputs"][0];
  expect_values(output, {{"/level", 0}, {"/vertices", 25}, {"/bake/size", 64}});
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
  EXPECT_EQ(run("fit plate.obj -o - --bake 64").out, read("p.glb"));
  run("fit plate.obj -o q.gltf --bake 64");
  EXPECT_EQ(read_json("q.gltf")["images"], document["images"]);
  EXPECT_THAT(names(), ElementsAre("p.glb", "plate.obj", "q.bin", "q.gltf", "r.json"));
  // Compression keeps both.
  for (const std::string mode : {"quantize", "meshopt"}) {
    run("fit plate.obj -f -o p.glb --bake 64 --compress " + mode);
    const json packed = document_of(read("p.glb"));
    EXPECT_TRUE(packed["meshes"][0]["primitives"][0]["attributes"].contains("TANGENT")) << mode;
    EXPECT_EQ(packed["images"].size(), 1U);
  }
}

TEST_F(BakeCommand, GivesEachMeshOfAnAssetItsMaps) {
  const json maps = bake_sample()["outputs"][0]["bake"]["maps"];
  EXPECT_THAT(said_, AllOf(HasSubstr("2 meshes, first ball: has no texture coordinates"),
                           HasSubstr("it stays without a map")));
  ASSERT_EQ(maps.size(), 2U);
  expect_values(maps, {{"/0/mesh", "tube"}, {"/0/material", "check"}, {"/1/material", "red"}});
  EXPECT_NEAR(maps[1]["covered"].get<double>(), 0.5, 1e-6);
  for (const char* kept : {"nodes", "skins", "animations", "cameras", "scenes"})
    EXPECT_EQ(made_[kept].size(), sample_.json[kept].size()) << kept;
  const json& primitives = made_["meshes"][0]["primitives"];
  for (const json& primitive : primitives) {
    for (const char* name : {"TANGENT", "JOINTS_0", "WEIGHTS_0", "TEXCOORD_1"})
      EXPECT_TRUE(primitive["attributes"].contains(name)) << name;
    EXPECT_EQ(primitive["targets"].size(), 1U);
  }
  // The red material is also that of a mesh without coordinates, which keeps it as it is.
  expect_values(primitives, {{"/0/material", 0}, {"/1/material", 3}});
  EXPECT_EQ(made_["meshes"][2]["primitives"][0]["material"], 1);
  const json& materials = made_["materials"];
  EXPECT_EQ(materials[1], sample_.json["materials"][1]);
  EXPECT_EQ(materials[3]["name"], "red");
  // The clear coat of the other one has no normals of its own.
  EXPECT_EQ(materials[0]["normalTexture"],
            materials[0]["extensions"]["KHR_materials_clearcoat"]["clearcoatNormalTexture"]);
  EXPECT_EQ(made_["images"].size(), 3U);
}

TEST_F(BakeCommand, LiesByTheSetThatTheNormalTextureNames) {
  sample_.json["materials"][0]["normalTexture"] = {{"index", 0}, {"texCoord", 1}, {"scale", 0.5}};
  const json maps = bake_sample()["outputs"][0]["bake"]["maps"];
  // Its scale is in the map.
  EXPECT_EQ(made_["materials"][0]["normalTexture"], (json{{"index", 1}, {"texCoord", 1}}));
  // That set has half the width and height.
  EXPECT_NEAR(maps[0]["covered"].get<double>(), 0.125, 1e-6);
  EXPECT_NEAR(maps[1]["covered"].get<double>(), 0.5, 1e-6);
}

TEST_F(BakeCommand, VariantsOfMaterialsAreTold) {
  sample_.json["extensionsUsed"].push_back("KHR_materials_variants");
  sample_.json["extensions"]["KHR_materials_variants"] = {
      {"variants", {{{"name", "a"}}, {{"name", "b"}}}}};
  sample_.json["meshes"][0]["primitives"][1]["extensions"]["KHR_materials_variants"] = {
      {"mappings", {{{"material", 1}, {"variants", {0}}}, {{"material", 2}, {"variants", {1}}}}}};
  bake_sample();
  EXPECT_THAT(said_, HasSubstr("variants of materials keep the normal textures"));
  const json primitive = made_["meshes"][0]["primitives"][1];
  EXPECT_EQ(primitive["material"], 3);
  const json& mappings = primitive["extensions"]["KHR_materials_variants"]["mappings"];
  expect_values(mappings, {{"/0/material", 3}, {"/1/material", 2}});
}

// Two meshes of one material: each has a copy of its own, the last one the material itself.
TEST_F(BakeCommand, MeshesShareNoMap) {
  sample_.json["meshes"].push_back(sample_.json["meshes"][0]);
  sample_.json["nodes"].push_back({{"mesh", 3}, {"skin", 0}});
  sample_.json["scenes"][0]["nodes"].push_back(9);
  bake_sample();
  std::set<int> materials, images;
  for (const int mesh : {0, 3})
    for (const json& primitive : made_["meshes"][mesh]["primitives"]) {
      const int material = primitive["material"];
      materials.insert(material);
      const int texture = made_["materials"][material]["normalTexture"]["index"];
      images.insert(made_["textures"][texture]["source"].get<int>());
    }
  EXPECT_EQ(materials.size(), 4U);
  EXPECT_EQ(images.size(), 4U);
}

// A texture that repeats on one material leaves the map of another alone.
TEST_F(BakeCommand, LeavesOutWhatRepeats) {
  write("two.obj", mapped_plate() +
                       "usemtl brick\nv 3 0 0\nv 4 0 0\nv 4 1 0\nv 3 1 0\n"
                       "vt 0 0\nvt 3 0\nvt 3 3\nvt 0 3\nf -4/-4 -3/-3 -2/-2 -1/-1\n");
  const json maps = report_of("fit two.obj -o p.glb --bake 64")["outputs"][0]["bake"]["maps"];
  EXPECT_THAT(said_, HasSubstr("two.obj: material `brick`: its texture repeats (face 16, "));
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_EQ(maps[0]["material"], "bark");
}

TEST_F(Needs, OfBakedMapsAreKnown) {
  write("plate.obj", mapped_plate(40));
  expect_enough("plate.obj -o p.glb --bake 64");
  expect_enough("plate.obj -o p.glb --bake 2048");
  // A page holds where the texture is.
  write("large.obj", mapped_plate(120));
  expect_enough("large.obj --page p.html");
}

}  // namespace
}  // namespace planish::test
